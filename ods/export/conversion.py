"""Converts a recording to a file of another format, completely or not at all."""

import shutil
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ods.base import clock
from ods.base.clock import NS
from ods.base.command_line.terminal import StatusLine
from ods.base.errors import OdsError, reason_of
from ods.export.sink import Sink, UnfitMessageError
from ods.messages import Detections, Health, ObstacleList, Ping, Pose
from ods.recording.mcap.reader import Recorded

END_OF_TIME_NS = 2**31 * NS
"""January 2038: the seconds of a ROS time are 32 bits."""
STATUS_PERIOD_NS = NS // 4
TOPICS = ("ping", "detections", "pose", "obstacles", "health")
"""Those that formats know; the others are not read."""


class ExportError(OdsError):
    """A recording cannot be exported; the text is one line."""


class Done(NamedTuple):
    """What became of a recording's messages."""

    taken: int
    """Messages that were given to the format."""
    losses: "Counter[str]"
    """Why others were not, and how many."""


def export(messages: Iterable[Recorded], out: Path, make: Callable[[Path], Sink]) -> Done:
    """Write `messages` to `out` by the format that `make` makes. Raises OdsError; then there is no `out`."""
    _refuse(out)
    status = StatusLine()
    try:
        done = _written(messages, make(out), status)
    except BaseException as error:
        _remove(out)
        if isinstance(error, OSError):
            raise ExportError(f"{out}: {reason_of(error)}") from error
        raise
    finally:
        status.clear()
    if not done.taken:
        _remove(out)
        raise ExportError("there is nothing to export in the recording")
    return done


def _written(messages: Iterable[Recorded], sink: Sink, status: StatusLine) -> Done:
    losses = Counter[str]()
    taken, shown_ns = 0, clock.monotonic_ns()
    with np.errstate(all="ignore"):  # messages may hold any number
        for recorded in messages:
            why = _take(recorded, sink)
            if why:
                losses[why] += 1
            else:
                taken += 1
            if clock.monotonic_ns() - shown_ns > STATUS_PERIOD_NS:
                status.show(f"{taken} messages")
                shown_ns = clock.monotonic_ns()
        sink.close()
    return Done(taken, losses + sink.losses)


def _take(recorded: Recorded, sink: Sink) -> str:
    """Give a message to the format; return why it was not taken."""
    try:
        message = recorded.message()
    except ValueError:
        return f"bad_{recorded.topic}"
    if not isinstance(message, Ping | Detections | Pose | ObstacleList | Health):
        return f"unknown_{recorded.topic}"
    stamp_ns = message.t_ns + recorded.utc_ns - recorded.log_ns
    if not 0 <= stamp_ns < END_OF_TIME_NS:
        return "messages outside the years 1970 to 2037"
    try:
        sink.take(stamp_ns, message)
    except UnfitMessageError as error:
        return str(error)
    return ""


def _refuse(out: Path) -> None:
    """Raises ExportError where nothing new can be made."""
    try:
        there, folder = out.exists() or out.is_symlink(), out.parent.is_dir()
    except OSError as error:
        raise ExportError(f"{out}: {reason_of(error)}") from error
    if there:
        raise ExportError(f"{out}: already exists, and is not overwritten")
    if not folder:
        raise ExportError(f"{out}: there is no folder {out.parent}")


def _remove(out: Path) -> None:
    with suppress(OSError):
        if out.is_dir():
            shutil.rmtree(out, ignore_errors=True)
        else:
            out.unlink(missing_ok=True)
