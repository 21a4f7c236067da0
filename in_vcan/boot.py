"""Boots a guest kernel on this machine's own files, lets it run the job, and passes on what it says."""

import contextlib
import json
import os
import shlex
import shutil
import socket
import sys
import tempfile
import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

from in_vcan import guest
from in_vcan.job import OUT_OF_TIME, Job, NotHereError, say
from in_vcan.keeper import keep

CRASHED = 1
"""Exit status when the guest ended while the command was running."""
MALLOC = {
    "MALLOC_MMAP_THRESHOLD_": "1000000000",
    "MALLOC_TRIM_THRESHOLD_": "2000000000",
    "MALLOC_TOP_PAD_": "16777216",
}
"""A page fault costs a guest 50 us: let malloc keep the memory it has (numpy gets 20 to 200 times faster)."""


@dataclass(frozen=True)
class Run:
    """One boot, as the machine's command line needs it."""

    folder: Path
    """Private, seen by host and guest alike."""
    init: Path
    """The guest's first process."""
    stdout: int
    """Descriptor that takes the command's standard output."""
    stderr: int


@dataclass(frozen=True)
class Machine:
    """A way to run a guest kernel."""

    name: str
    command: Callable[[Run], list[str]]
    streams: tuple[str, str]
    """The guest's devices behind which `Run.stdout` and `Run.stderr` are."""
    modules: Iterable[tuple[str, bytes]] = ()
    """Kernel modules, name and content, for the guest to insert in this order."""
    environment: dict[str, str] = field(default_factory=dict)
    """What is different for the command."""


def run(job: Job, machine: Machine) -> int:
    """Run the job in a new guest; return its exit status. Raises NotHereError when the guest does not get up."""
    say(f"in {machine.name}")
    folder = Path(tempfile.mkdtemp(prefix="in-vcan-", dir="/tmp"))  # no blank: it stands in a kernel's command line
    try:
        _describe(job, machine, folder)
        # the keeper removes the folder, lest a killed runner leave it; what is open stays readable
        with (folder / "log").open("w+b") as log, (folder / "status").open("w+b") as status:
            code = _boot(job, machine, folder, log)
            return code if code == OUT_OF_TIME else _verdict(status.read().decode(), log)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _describe(job: Job, machine: Machine, folder: Path) -> None:
    """Write what the guest reads: its first process, its modules, and what to run."""
    umask = os.umask(0)
    os.umask(umask)
    task = {
        "command": job.command,
        "cwd": str(Path.cwd()),
        "environment": MALLOC | os.environ | machine.environment,
        "umask": umask,
        "streams": machine.streams,
        "hostname": socket.gethostname(),
    }
    (folder / "job.json").write_text(json.dumps(task))
    (folder / "modules").mkdir()
    for place, (name, content) in enumerate(machine.modules):
        (folder / "modules" / f"{place:02d}-{name}").write_bytes(content)
    package_root = Path(guest.__file__).parents[1]
    words = [sys.executable, "-S", "-P", "-m", guest.__name__, str(folder)]
    init = folder / "init"
    init.write_text(f"#!/bin/sh\nPYTHONPATH={shlex.quote(str(package_root))} exec {shlex.join(words)}\n")
    init.chmod(0o700)


def _boot(job: Job, machine: Machine, folder: Path, log: IO[bytes]) -> int:
    """Run the guest to its end, and its two streams into ours; return the keeper's status."""
    pipes = [os.pipe(), os.pipe()]
    writers = (pipes[0][1], pipes[1][1])
    pumps = [
        threading.Thread(target=_pump, args=(reader, sink), daemon=True)
        for (reader, _), sink in zip(pipes, (1, 2), strict=True)
    ]
    for pump in pumps:
        pump.start()
    command = machine.command(Run(folder, folder / "init", *writers))
    code = keep(command, job.timeout_s, [["rm", "-rf", str(folder)]], stdout=log, pass_fds=writers)
    for writer in writers:
        os.close(writer)
    for pump in pumps:
        pump.join()
    return code


def _pump(source: int, sink: int) -> None:
    """Copy until the end; go on reading when nobody wants it any more, as a full pipe would hold up the guest."""
    while data := os.read(source, 65536):
        with contextlib.suppress(BrokenPipeError):
            while data:
                data = data[os.write(sink, data) :]


def _verdict(status: str, log: IO[bytes]) -> int:
    if status.isdecimal():
        return int(status)
    log.seek(0)
    lines = log.read().decode(errors="replace").strip().splitlines()
    if status == guest.RUNNING:
        say("\n".join(["the guest crashed; its last words:", *lines[-20:]]))
        return CRASHED
    telling = [line for line in lines if line.startswith(guest.SAYS)] or lines or ["no word from it"]
    raise NotHereError(f"the guest did not get up: {telling[-1].strip()}")
