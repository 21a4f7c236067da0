"""Missions on a Dask cluster: a real scheduler and two workers on this machine, over TLS, one of which is killed."""

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import pytest
from msgspec.structs import replace

from ods.base.errors import OdsError
from ods.base.files.shipped import shipped_file
from ods.base.settings_file import load
from ods.missions.outcome import Flown
from ods.missions.parallel.fly import fly, tasks_of
from ods.missions.parallel.workers import Task
from ods.missions.settings import Campaign
from tests.missions.campaigns import results

pytest.importorskip("distributed")
from ods.missions.parallel.cluster import flown_on_cluster, security_of

CAMPAIGN = """
seed = 3
missions = 4
arms = ["none", "ods", "truth"]
[world]
length_m = 45.0
width_m = 40.0
obstacles_per_hectare = 40.0
"""
DASK = [sys.executable, "-m"]


class Cluster(NamedTuple):
    """A scheduler and its workers."""

    address: str
    tls: Path
    workers: list["subprocess.Popen[bytes]"]


def certificates(folder: Path) -> Path:
    """Make one authority and one certificate, for both sides."""
    if shutil.which("openssl") is None:
        pytest.skip("no openssl to make certificates with")
    folder.mkdir()
    make = ["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=missions"]
    files = ["-keyout", str(folder / "key.pem"), "-out", str(folder / "cert.pem")]
    subprocess.run([*make, *files], check=True, capture_output=True)
    shutil.copy(folder / "cert.pem", folder / "ca.pem")
    return folder


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    tls = certificates(tmp_path_factory.mktemp("cluster") / "tls")
    given = [
        f"--tls-{key}={tls / name}" for key, name in (("ca-file", "ca.pem"), ("cert", "cert.pem"), ("key", "key.pem"))
    ]
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tls://127.0.0.1:{free.getsockname()[1]}"
    listen = ["--host", "127.0.0.1", "--port", address.rpartition(":")[2], "--protocol", "tls", "--no-dashboard"]
    single = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"]
    single += ["--local-directory", str(tls)]
    with ExitStack() as running:

        def start(*command: str) -> "subprocess.Popen[bytes]":
            process = subprocess.Popen([*DASK, *command, *given], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            running.callback(process.wait)
            running.callback(process.kill)
            return process

        start("distributed.cli.dask_scheduler", *listen)
        workers = [start("distributed.cli.dask_worker", address, *single) for _ in range(2)]
        yield Cluster(address, tls, workers)


@pytest.mark.slow
def test_one_process_two_and_two_dask_workers_make_the_same_bytes(campaign: Path, cluster: Cluster) -> None:
    one = results(campaign, "one")
    assert results(campaign, "two", "--workers", "2") == one
    assert results(campaign, "dask", "--cluster", cluster.address, "--tls", str(cluster.tls)) == one


def killed_once(task: Task) -> Flown:
    """Kill the worker that gets mission 1 first; beside the campaign's sonar is the mark of that."""
    mark = Path(task.campaign.sonar).with_suffix(".killed")
    if task.number == 1 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return fly(task)


@pytest.mark.slow
def test_a_killed_worker_s_missions_are_flown_again_to_the_same(campaign: Path, cluster: Cluster) -> None:
    sonar = campaign.parent / "sonar.toml"
    shutil.copy(shipped_file("sonars/seabat6012.toml"), sonar)
    tasks = tasks_of(replace(load(campaign, Campaign), sonar=str(sonar), arms=("none", "truth")))
    wanted = [fly(task).outcome for task in tasks]
    flown = flown_on_cluster(tasks, killed_once, cluster.address, cluster.tls)
    assert [each.outcome for each in flown] == wanted
    deadline = time.monotonic() + 10.0
    while time.monotonic() < deadline and all(worker.poll() is None for worker in cluster.workers):
        time.sleep(0.05)
    assert any(worker.poll() == -signal.SIGKILL for worker in cluster.workers)


@pytest.mark.slow
def test_a_client_without_the_certificate_is_not_taken(campaign: Path, cluster: Cluster, tmp_path: Path) -> None:
    other = certificates(tmp_path / "other")
    with pytest.raises(OdsError, match="the scheduler refused the connection"):
        list(flown_on_cluster(tasks_of(load(campaign, Campaign)), fly, cluster.address, other))


@pytest.mark.parametrize(
    ("address", "reported"),
    [
        ("tcp://192.0.2.1:8786", "without TLS only on this machine"),
        ("tcp://example.org:8786", "without TLS only on this machine"),
        ("tls://127.0.0.1:8786", "needs --tls"),
        ("127.0.0.1:8786", "expected tls://HOST:PORT"),
    ],
)
def test_an_address_that_anyone_could_reach_is_refused(address: str, reported: str) -> None:
    with pytest.raises(OdsError, match=reported):
        security_of(address, None)


def test_on_this_machine_no_tls_is_needed() -> None:
    assert security_of("tcp://127.0.0.1:8786", None) is None
    assert security_of("tcp://[::1]:8786", None) is None
