"""First process of a guest kernel whose root is the host's: makes it a home, runs the command, powers off.

A program of its own, started with nothing of Linux's usual services up; its one argument is the folder of the run.
"""

import ctypes
import json
import os
import socket
import subprocess
import sys
import termios
import threading
import tty
from pathlib import Path
from typing import Any

from in_vcan import links

MOUNTS = [
    ("proc", "/proc", ""),
    ("sysfs", "/sys", ""),
    ("devtmpfs", "/dev", ""),
    ("devpts", "/dev/pts", "mode=620,ptmxmode=666"),
    ("tmpfs", "/dev/shm", "mode=1777"),
    ("tmpfs", "/run", "mode=755"),
]
DEV_LINKS = {"fd": "/proc/self/fd", "stdin": "fd/0", "stdout": "fd/1", "stderr": "fd/2"}
FINIT_MODULE = 313
"""System call number on x86-64."""
RB_POWER_OFF = 0x4321FEDC
RUNNING = "running"
"""What the file `status` says before it has the exit status."""
SAYS = "guest:"
DRAIN_S = 2.0
"""How long a daemon that the command left behind may hold its output."""

libc = ctypes.CDLL(None, use_errno=True)


def main(folder: Path) -> None:
    """Run the job described in the folder."""
    try:
        job = json.loads((folder / "job.json").read_text())
        _make_home(job["hostname"])
        for module in sorted((folder / "modules").iterdir()):
            _insert(module)
        links.up("lo")
        links.ensure()
        status = _run(job, folder)
        (folder / "status").write_text(str(status))
    except OSError as error:
        print(SAYS, error, flush=True)  # on the console, which is the log
    finally:
        os.sync()
        libc.reboot(RB_POWER_OFF)


def _make_home(hostname: str) -> None:
    for kind, place, options in MOUNTS:
        if not Path(place).is_mount():  # the kernel may have mounted its devtmpfs already
            _checked(libc.mount(kind.encode(), place.encode(), kind.encode(), 0, options.encode()), f"mount {place}")
        if kind == "devtmpfs":
            for folder in ("pts", "shm"):
                Path("/dev", folder).mkdir(exist_ok=True)
            for name, target in DEV_LINKS.items():
                Path("/dev", name).symlink_to(target)
    socket.sethostname(hostname)


def _insert(module: Path) -> None:
    with module.open("rb") as file:
        _checked(libc.syscall(FINIT_MODULE, file.fileno(), b"", 0), f"insert {module.name}")


def _checked(result: int, what: str) -> None:
    if result:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()), what)


def _run(job: dict[str, Any], folder: Path) -> int:
    """Run the command, its two streams pumped into the two devices; return its exit status."""
    sinks = [os.open(device, os.O_WRONLY | os.O_NOCTTY) for device in job["streams"]]
    for sink in sinks:
        if os.isatty(sink):
            tty.setraw(sink)
    (folder / "status").write_text(RUNNING)
    try:
        # pipes, so that the command sees no terminal
        command = subprocess.Popen(
            job["command"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=job["cwd"],
            env=job["environment"],
            umask=job["umask"],
            start_new_session=True,
        )
    except OSError as error:
        os.write(sinks[1], f"{job['command'][0]}: {error.strerror}\n".encode())
        status = 127 if isinstance(error, FileNotFoundError) else 126
    else:
        assert command.stdout is not None
        assert command.stderr is not None
        pumps = [
            threading.Thread(target=_pump, args=(source.fileno(), sink), daemon=True)
            for source, sink in zip((command.stdout, command.stderr), sinks, strict=True)
        ]
        for pump in pumps:
            pump.start()
        status = _reap_until(command.pid)
        for pump in pumps:
            pump.join(DRAIN_S)
    for sink in sinks:
        if os.isatty(sink):
            termios.tcdrain(sink)
    return status


def _pump(source: int, sink: int) -> None:
    while data := os.read(source, 65536):
        while data:
            data = data[os.write(sink, data) :]


def _reap_until(wanted: int) -> int:
    """Bury orphans, as the first process must, until the wanted process ends; return its status as a shell has it."""
    while True:
        pid, status = os.waitpid(-1, 0)
        if pid == wanted:
            code = os.waitstatus_to_exitcode(status)
            return code if code >= 0 else 128 - code


if __name__ == "__main__":
    main(Path(sys.argv[1]))
