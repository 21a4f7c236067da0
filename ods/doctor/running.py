"""The running processes and their health."""

import os
from collections.abc import Iterator
from pathlib import Path

import zmq

from ods.base import clock
from ods.base.computer.overload import OverloadMonitor
from ods.doctor.finding import Finding
from ods.messages import Health
from ods.runtime import bus
from ods.runtime.processes import SUPERVISOR, may_be_on_board, on_board
from ods.runtime.run_dir import is_locked

LISTEN_S = 1.5


def sockets(run_dir: Path) -> Iterator[Finding]:
    """Report which processes run, and their health."""
    if not _may_be_used(run_dir):
        yield Finding("wrong", "sockets", f"{run_dir} may not be used by this user")
        return
    running = [process.name for process in may_be_on_board() if is_locked(run_dir, process.name)]
    if not running:
        yield Finding("note", "processes", f"none runs on {run_dir}")
        return
    overload = OverloadMonitor()
    overload.look(clock.monotonic_ns())
    health = _listen(run_dir, running)
    for process in may_be_on_board():
        report = health.get(process.name)
        if process.name not in running and process.by_configuration:
            continue
        if process.name not in running:
            problems = "; ".join(report.problems) if report else ""
            yield Finding("wrong", process.name, problems or "does not run, although others do")
        elif report is None:
            late = overload.problem(clock.monotonic_ns())  # which does not say that it would answer on an idle one
            why = "it hangs, or is starting" + (f", or is only late, as {late}" if late else "")
            yield Finding("wrong", process.name, f"runs, but gave no sign of life within {LISTEN_S} s: {why}")
        elif report.problems:
            yield Finding("wrong", process.name, "; ".join(report.problems))
        else:
            yield Finding("good", process.name, "runs without problems" if report.ready else "is starting")


def _may_be_used(run_dir: Path) -> bool:
    """Return whether this user may look into the folder; one that is not there yet is no hindrance."""
    try:
        run_dir.stat()
    except FileNotFoundError:
        return True
    except OSError:  # the folder that it is in may not be looked into
        return False
    return os.access(run_dir, os.R_OK | os.X_OK)


def _listen(run_dir: Path, names: list[str]) -> dict[str, Health]:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    health: dict[str, Health] = {}
    deadline_ns = clock.monotonic_ns() + int(LISTEN_S * clock.NS)
    with bus.Subscriber(context, run_dir, [], [*names, SUPERVISOR]) as subscriber:
        while len(health) < max(len(names), len(on_board())) and clock.monotonic_ns() < deadline_ns:
            for _, message in subscriber.receive(0.1)[0]:
                health[message.process] = message
    context.term()
    return health
