"""Keeps a command: nothing of it outlives the process that holds the other end of the keeper's standard input.

A program of its own, as its holder may be killed without a word: end of file on the standard input is the one sign
that always comes. It is the subreaper of all that the command starts, so daemons that left their session are found too.
"""

import contextlib
import ctypes
import json
import os
import select
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import IO, Any

PR_SET_CHILD_SUBREAPER = 36
OUT_OF_TIME = 124
HOLDER_GONE = 143
PATIENCE_S = 10.0


def keep(
    command: list[str],
    timeout_s: float | None,
    afterwards: list[list[str]],
    stdout: IO[bytes] | None = None,
    pass_fds: tuple[int, ...] = (),
) -> int:
    """Run a command under a keeper; return its exit status, or OUT_OF_TIME.

    `afterwards` are commands that clear up, run in any event. `stdout` is for both of the command's streams.
    """
    task = json.dumps({"command": command, "timeout_s": timeout_s, "afterwards": afterwards})
    with subprocess.Popen(
        [sys.executable, "-I", "-S", __file__, task],
        stdin=subprocess.PIPE,
        stdout=stdout,
        stderr=subprocess.STDOUT if stdout else None,
        pass_fds=pass_fds,
        start_new_session=True,  # Ctrl-C reaches the holder alone
    ) as keeper:
        return keeper.wait()


def main(task: dict[str, Any]) -> int:
    """Run the task to its end, the holder's end or the end of its time."""
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(HOLDER_GONE))
    try:
        return _watch(task["command"], task["timeout_s"])
    finally:
        _end_descendants()
        for command in task["afterwards"]:
            subprocess.run(command, stderr=subprocess.DEVNULL)


def _watch(command: list[str], timeout_s: float | None) -> int:
    try:
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, close_fds=False)
    except OSError as error:
        print(f"{command[0]}: {error.strerror}", file=sys.stderr)
        return 127 if isinstance(error, FileNotFoundError) else 126
    ended = os.pidfd_open(child.pid)
    ready = select.select([ended, sys.stdin], [], [], timeout_s)[0]
    if ended in ready:
        status = child.wait()
        return status if status >= 0 else 128 - status
    return HOLDER_GONE if ready else OUT_OF_TIME


def _end_descendants() -> None:
    """Kill every descendant, and wait until they are gone.

    User-mode Linux must not die before its guest's processes, which are its traced children: they would run on as
    processes of the host. Hence first stop from the top, then kill from the bottom.
    """
    deadline_s = time.monotonic() + PATIENCE_S
    while (pids := _descendants()) and time.monotonic() < deadline_s:
        for pid in pids:
            _signal(pid, signal.SIGSTOP)
        for pid in reversed(pids):
            _signal(pid, signal.SIGKILL)
        with contextlib.suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG) != (0, 0):
                pass
        time.sleep(0.01)


def _descendants() -> list[int]:
    """Return the living descendants of this process, parents before children."""
    children: dict[int, list[int]] = {}
    for file in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, parent = file.read_text(errors="replace").rpartition(")")[2].split()[:2]
        except OSError:
            continue
        if state != "X":
            children.setdefault(int(parent), []).append(int(file.parent.name))
    found = [os.getpid()]
    for pid in found:  # grows while it is walked
        found += children.get(pid, [])
    return found[1:]


def _signal(pid: int, number: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.kill(pid, number)


if __name__ == "__main__":
    sys.exit(main(json.loads(sys.argv[1])))
