"""Missions on the workers of a Dask cluster: results in order, and again where a worker was killed.

Dask runs what it is sent, so whoever reaches a scheduler runs what they like on all of its workers: it is spoken to
over TLS, where both sides show certificates, or on this machine only.
"""

import hashlib
from collections.abc import Iterator, Sequence
from ipaddress import ip_address
from pathlib import Path
from typing import Any

import msgspec
from distributed import Client, KilledWorker
from distributed.security import Security

from ods.base.errors import OdsError, one_line
from ods.missions.outcome import Flown
from ods.missions.parallel.fly import depends_on
from ods.missions.parallel.workers import AHEAD, Fly, Task
from ods.missions.settings import Campaign

PATIENCE_S = 10.0
"""Time that the scheduler may take to answer, s."""
CA, CERT, KEY = "ca.pem", "cert.pem", "key.pem"
"""What the folder of --tls holds."""


def flown_on_cluster(tasks: Sequence[Task], fly: Fly, address: str, tls: Path | None) -> Iterator[Flown]:
    """Yield what comes of each task, in their order. `address`: tls://HOST:PORT, or tcp:// on this machine.

    `tls`: a folder with CA, CERT and KEY. Raises OdsError.
    """
    if not tasks:
        return
    security = security_of(address, tls)
    try:
        client = Client(address, security=security, set_as_default=False, timeout=PATIENCE_S)
    except (OSError, TimeoutError, ValueError) as error:
        raise OdsError(f"--cluster: {address}: the scheduler refused the connection: {one_line(error)}") from error
    with client:
        yield from _of_client(client, tasks, fly, address)


def security_of(address: str, tls: Path | None) -> Security | None:
    """Return how to speak to a scheduler; None: in the clear, on this machine. Raises OdsError."""
    scheme, _, place = address.partition("://")
    if scheme == "tls":
        if tls is None:
            raise OdsError(f"--cluster: {address}: needs --tls, a folder with {CA}, {CERT} and {KEY}")
        files = [tls / name for name in (CA, CERT, KEY)]
        for file in files:
            if not file.is_file():
                raise OdsError(f"--tls: {file}: no such file")
        ca, cert, key = map(str, files)
        return Security(tls_ca_file=ca, tls_client_cert=cert, tls_client_key=key, require_encryption=True)
    if scheme != "tcp":
        raise OdsError(f"--cluster: {address}: expected tls://HOST:PORT, or tcp://127.0.0.1:PORT on this machine")
    if not _is_here(place.rpartition(":")[0].strip("[]")):
        raise OdsError(
            f"--cluster: {address}: without TLS only on this machine, as a scheduler runs any code it receives"
        )
    return None


def _is_here(host: str) -> bool:
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def fly_alike(fly: Fly, digest: str, task: Task) -> Flown:
    """Fly one mission on a worker whose version and files are those of who asks. Raises OdsError."""
    if digest_of(task.campaign) != digest:
        raise OdsError("--cluster: a worker has another version of ODS or of the campaign's files than this machine")
    return fly(task)


def digest_of(campaign: Campaign) -> str:
    """Return what distinguishes one campaign's ODS, sonar and settings from another's. Raises OdsError."""
    return hashlib.sha256(msgspec.json.encode(depends_on(campaign), enc_hook=str)).hexdigest()


def _of_client(client: Client, tasks: Sequence[Task], fly: Fly, address: str) -> Iterator[Flown]:
    waiting: list[tuple[Task, Any]] = []
    digests: dict[int, str] = {}
    given = 0
    while given < len(tasks) or waiting:
        most = AHEAD * max(1, sum(client.nthreads().values()))
        while given < len(tasks) and len(waiting) < most:
            task = tasks[given]
            if id(task.campaign) not in digests:
                digests[id(task.campaign)] = digest_of(task.campaign)
            digest = digests[id(task.campaign)]
            waiting.append((task, client.submit(fly_alike, fly, digest, task, pure=False)))
            given += 1
        task, future = waiting.pop(0)
        try:
            flown: Flown = future.result()
        except KilledWorker:
            raise OdsError(f"mission {task.number} of arm {task.arm!r}: all workers that ran it were killed") from None
        except OdsError:
            raise
        except Exception as error:
            raise OdsError(f"--cluster: {address}: {type(error).__name__}: {one_line(error)}") from error
        yield flown
