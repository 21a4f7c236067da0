"""`ods watch`: obstacles and health in the terminal, live or once, as a table or as JSON."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base import clock
from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.commands.watched import watch_json
from ods.commands.watched.received import Received, listen, read_once
from ods.config import OnboardConfig
from ods.runtime import bus

COLUMNS = (
    "north, east, down: of [site], with one standard deviation; state: active (observed), stand_by (not lately), "
    "hibernated (out of view, kept in the map); nearest m, in s: least distance to the edge, below 0 inside, "
    "and when, if both keep their velocity; exists: probability; seen: times detected."
)
"""Meaning of the table's columns."""


def add_arguments(parser: ArgumentParser) -> None:
    """Live or once, for people or for programs."""
    parser.epilog = COLUMNS
    parser.add_argument("--once", action="store_true", help="print once; exit code 0: the list is valid, 1: it is not")
    parser.add_argument("--json", action="store_true", help="with --once: one JSON object instead of the table")


def run(args: Namespace) -> int:
    """Show what the processes of a configuration publish, until interrupted or once. Raises OdsError."""
    if args.json and not args.once:
        raise OdsError("--json needs --once")
    run_dir = load(args.config, OnboardConfig).bus.run_dir
    if args.once:
        return _once(run_dir, as_json=args.json)
    from ods.commands.watched import watch_screen  # rich is not on board

    watch_screen.live(listen(run_dir), lambda: bus.unreachable_reason(run_dir, "tracker"))
    return 0


def _once(run_dir: Path, *, as_json: bool) -> int:
    """Print the state once; return 0 if the list is valid, otherwise 1."""
    received = read_once(run_dir)
    if as_json:
        unreachable_reason = bus.unreachable_reason(run_dir, "tracker") if received.newest is None else ""
        print(watch_json.text(received, clock.monotonic_ns(), unreachable_reason))
    else:
        from ods.commands.watched import watch_screen

        watch_screen.once(received, lambda: bus.unreachable_reason(run_dir, "tracker"))
    return 0 if _is_valid(received) else 1


def _is_valid(received: Received) -> bool:
    return received.newest is not None and received.newest.valid and not received.silent(clock.monotonic_ns())
