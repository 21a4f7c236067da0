"""`python -m in_vcan [--timeout S] COMMAND...`: runs COMMAND where vcan0 and vcan1 exist.

Tries this host, then a network namespace, then User-mode Linux, then QEMU; ODS_VCAN=host|namespace|uml|qemu takes that
one only. The command has the caller's folder, environment and files, and /dev/null as its standard input.
Exit status: the command's; 124 out of time; 125 no way to get a vcan here.
"""

import argparse
import os
import signal
import sys
import time
from collections.abc import Callable

from in_vcan import host, namespace, qemu, uml
from in_vcan.job import NO_WAY, OUT_OF_TIME, Job, NotHereError, say

WAYS: dict[str, Callable[[Job], int]] = {
    "host": host.run,
    "namespace": namespace.run,
    "uml": uml.run,
    "qemu": qemu.run,
}


def main() -> int:
    """Run the command line's job the first way that works."""
    job = _job()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, _stop)
    begun_s = time.monotonic()
    reasons = []
    for name in _chosen():
        try:
            status = WAYS[name](job)
        except NotHereError as error:
            reasons.append(f"{name}: {error}")
            continue
        if status == OUT_OF_TIME and job.timeout_s and time.monotonic() - begun_s >= job.timeout_s:
            say(f"out of time after {job.timeout_s:g} s")
        return status
    say(f"no vcan to be had; {'; '.join(reasons)}")
    return NO_WAY


def _job() -> Job:
    parser = argparse.ArgumentParser(prog="python -m in_vcan", description="Run a command where vcan0 and vcan1 exist.")
    parser.add_argument("--timeout", type=float, metavar="S", help="seconds until the command is ended")
    parser.add_argument("command", nargs=argparse.REMAINDER, metavar="COMMAND...")
    given = parser.parse_args()
    command = given.command[1:] if given.command[:1] == ["--"] else given.command
    if not command:
        parser.error("which command?")
    return Job(command, given.timeout)


def _chosen() -> list[str]:
    wanted = os.environ.get("ODS_VCAN")
    if wanted and wanted not in WAYS:
        say(f"ODS_VCAN: expected one of {', '.join(WAYS)}, got {wanted}")
        sys.exit(2)
    return [wanted] if wanted else list(WAYS)


def _stop(number: int, _: object) -> None:
    sys.exit(128 + number)


if __name__ == "__main__":
    sys.exit(main())
