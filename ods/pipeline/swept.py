"""A mechanically scanned sonar: its beams to an image around the newest ones, and which echoes of that are new.

Each beam has its own time, so its own pose of the head. The image of a ping shows the newest beams of the sweep, as far
back as `WINDOW_RAD`, as if all had been sent from one pose, the reference: so a body that several pings touch is whole
in one of them, and the chain has the same geometry each time, as the image turns with the head. An echo is reported
once a sweep, when the head is past it: by the ping whose part of the sector, `GUARD_RAD` behind the newest beam, holds
its middle. That part is what the ping looked at; the rest of the sector is reported as not swept, so that no object
there is missed and no water there is empty.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import msgspec
import numpy as np

from ods.base.arrays import AnyArray, Floats
from ods.base.clock import NS
from ods.base.frames.geometry import rotation_matrix, wrap_angle
from ods.messages import Detection, Detections, Ping, Sector, Sweep, UnseenPart, frame_of
from ods.pipeline.filter.over_pings import KNOT
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.sight import area_of
from ods.pose.buffer import PoseEstimate

WINDOW_RAD = math.radians(60.0)
GUARD_RAD = math.radians(10.0)
"""An object of twice this width is complete when it is reported."""
WIDEST_RAD = WINDOW_RAD - GUARD_RAD
"""Of the beams of a ping."""
CLEAR_STEPS = 1.0
"""Beams between an echo's end and the newest beam from which on the echo is complete."""
SLACK_STEPS = 3.0
"""Beams by which an echo's end and middle may change from image to image."""
LONGEST_PAUSE_NS = 3 * NS
MOST_MISSING = 5.0
"""Beams between two pings of one sweep."""
HALF_TURN = math.pi + 1e-6

HeadAt = Callable[[int], PoseEstimate | None]


class Line(NamedTuple):
    """One beam."""

    number: int
    """In its sweep."""
    bearing: float
    """In the head's frame when it was sent, rad."""
    t_ns: int
    samples: AnyArray
    head: PoseEstimate | None


class Interval(NamedTuple):
    """Bearings, rad."""

    low: float
    high: float


class _Places(NamedTuple):
    """Places on beams, as seen from the reference: (lines, ranges) each."""

    bearing: Floats
    """rad."""
    farther_m: Floats
    """By how much than the beam says."""


class Swept(NamedTuple):
    """An image of the newest beams."""

    ping: Ping
    """With bearings about its own middle, sent at the reference."""
    middle: float
    """Bearing of that, in the head's frame at the reference, rad."""
    front: float
    """Bearing of the newest beam, likewise."""
    direction: int
    """1: the head turns to starboard, -1: to port."""
    looked: Interval | None
    """What this ping is to judge; None: nothing yet."""
    new_rad: float
    """By how much the head turned since the ping before."""
    sweep: Sweep
    head: PoseEstimate | None
    """At the reference."""


class SweptSonar:
    """Follows one head. `without_pose`: beams so far whose pose is not known, taken as sent at the reference."""

    def __init__(self, head_at: HeadAt) -> None:
        self.without_pose = 0
        self._head_at = head_at
        self._lines: list[Line] = []
        self._judged = 0
        """Number of the first beam that no ping has judged."""
        self._direction = 0
        self._ended = True
        self._way: tuple[object, ...] = ()
        self._t_ns: int | None = None
        """Of the newest reference."""
        self._reported: list[tuple[float, float, int]] = []
        """Echoes that have been reported and may still be in the image: north and east, m, and the newest beam then."""

    def image(self, ping: Ping) -> Swept:
        """Return the image that a ping completes. Raises PingError for an invalid one."""
        sweep = _checked(ping)
        direction = 1 if sweep.rising else -1
        beams = self._in_order(ping)
        if self._starts_again(ping, beams[0], direction):
            self._lines, self._judged, self._reported = [], 0, []
        first = self._lines[-1].number + 1 if self._lines else 0
        self._lines += [each._replace(number=first + place) for place, each in enumerate(beams)]
        self._direction, self._ended = direction, sweep.ends
        count = _beams_of(sweep)
        self._lines = self._lines[-count - round(MOST_MISSING) :]
        self._reported = [each for each in self._reported if each[2] >= self._lines[0].number]
        return self._made(ping, sweep, count, len(beams))

    def detections(self, swept: Swept, found: Detections) -> Detections:
        """Return the detections of the ping: echoes that are complete and new, and what was looked at."""
        echoes = self._new_ones(swept, found.detections)
        faint = self._new_ones(swept, found.faint)
        sector, seen = _sector(swept, found.sector)
        parts = _clipped(found.unseen, swept.middle, seen)
        looked = sum((each.high - each.low) * (sector.range_max_m - sector.range_min_m) for each in seen)
        share = area_of(parts) / max(looked, 1e-9) if found.usable else 1.0
        not_swept = [
            UnseenPart(*gap, sector.range_min_m, sector.range_max_m, "not swept") for gap in _gaps(sector, seen)
        ]
        return msgspec.structs.replace(
            found,
            sector=sector,
            detections=echoes,
            faint=faint,
            unseen=[*parts, *not_swept],
            unseen_share=min(share, 1.0),
            unseen_why=found.unseen_why if parts else "",
            turn_s=swept.sweep.turn_s,
        )

    def _in_order(self, ping: Ping) -> list[Line]:
        """Return the beams of a ping as they were sent."""
        rows = zip(ping.bearing_rad, ping.beam_t_ns, frame_of(ping), strict=True)
        lines = [Line(0, bearing, t_ns, row, self._head_at(t_ns)) for bearing, t_ns, row in rows]
        self.without_pose += sum(line.head is None for line in lines)
        return sorted(lines, key=lambda line: line.t_ns)

    def _starts_again(self, ping: Ping, first: Line, direction: int) -> bool:
        way = (ping.samples, ping.dr_m, ping.range0_m, ping.dtype, ping.scale, ping.scale_factor, ping.setting)
        step = ping.sweep.step_rad if ping.sweep else 0.0
        other, self._way = (*way, step) != self._way, (*way, step)
        if other or self._ended or direction != self._direction or not self._lines:
            return True
        newest = self._lines[-1]
        onward = direction * math.remainder(first.bearing - newest.bearing, 2.0 * math.pi) / step
        return not (0.0 < onward < MOST_MISSING and 0 <= first.t_ns - newest.t_ns < LONGEST_PAUSE_NS)

    def _made(self, ping: Ping, sweep: Sweep, count: int, fresh: int) -> Swept:
        lines, step, direction = self._lines, sweep.step_rad, 1 if sweep.rising else -1
        judged = self._to_judge(sweep)
        reference = judged[-1] if judged else lines[0]
        self._t_ns = reference.t_ns if self._t_ns is None else max(reference.t_ns, self._t_ns + 1)
        range_m = ping.range0_m + ping.dr_m * np.minimum(KNOT // 2 + np.arange(0, ping.samples, KNOT), ping.samples - 1)
        seen = _as_from(lines, reference.head, range_m)
        aim = seen.bearing[:, len(range_m) // 2]
        front = float(aim[-1])
        middle = front - direction * 0.5 * (count - 1) * step
        looked = None
        if judged:
            aims = [aim[line.number - lines[0].number] for line in (judged[0], judged[-1])]
            behind = [front + math.remainder(float(each) - front, 2.0 * math.pi) for each in aims]
            looked = Interval(min(behind) - 0.5 * step, max(behind) + 0.5 * step)
        table = np.asarray((np.arange(count) - 0.5 * (count - 1)) * step, np.float64)
        image = _image(ping, np.stack([line.samples for line in lines]), seen, middle, table)
        utc_ns = ping.utc_ns - (ping.t_ns - self._t_ns)
        image = msgspec.structs.replace(image, t_ns=self._t_ns, utc_ns=utc_ns)
        return Swept(image, middle, front, direction, looked, fresh * step, sweep, reference.head)

    def _to_judge(self, sweep: Sweep) -> list[Line]:
        """Return the beams that the newest ones let be judged, and take note of that."""
        lines = self._lines
        until = lines[-1].number + 1 - (0 if sweep.ends else round(GUARD_RAD / sweep.step_rad))
        judged = [line for line in lines if self._judged <= line.number < until]
        self._judged = max(self._judged, until)
        return judged

    def _new_ones(self, swept: Swept, echoes: Sequence[Detection]) -> list[Detection]:
        """Return the echoes that this ping reports, with bearings in the head's frame."""
        turned = [_turned(echo, swept.middle) for echo in echoes]
        return sorted((echo for echo in turned if self._is_new(swept, echo)), key=lambda echo: echo.bearing_rad)

    def _is_new(self, swept: Swept, echo: Detection) -> bool:
        step = swept.sweep.step_rad
        place = swept.direction * math.remainder(echo.bearing_rad - swept.front, 2.0 * math.pi)
        foremost = place + 0.5 * echo.bearing_extent_rad
        past = place <= -GUARD_RAD
        if not swept.sweep.ends and foremost > -CLEAR_STEPS * step:
            return past  # so wide that it is reported before all of it was observed
        due = max(place + GUARD_RAD, foremost + CLEAR_STEPS * step)
        if due < -swept.new_rad - SLACK_STEPS * step or not (swept.sweep.ends or past):
            return False
        north, east = _place(echo, swept.head)
        near_m = max(echo.radius_m, 2.0 * step * echo.range_m)
        if any(math.hypot(north - n, east - e) < near_m for n, e, _ in self._reported):
            return False
        self._reported.append((north, east, self._lines[-1].number))
        return True


def _checked(ping: Ping) -> Sweep:
    """Return the sweep of a ping that makes sense. Raises PingError."""
    sweep = ping.sweep
    if sweep is None or not sweep.step_rad > 0.0 or len(ping.beam_t_ns) != ping.beams != 0:
        raise PingError("sweep: the step or the times of the beams are missing")
    low, high = sweep.bearing_min_rad, sweep.bearing_max_rad
    if len(ping.bearing_rad) != ping.beams or not -HALF_TURN <= low <= high <= HALF_TURN:
        raise PingError("sweep: the bearings are invalid")
    if max(ping.bearing_rad) - min(ping.bearing_rad) > WIDEST_RAD:
        raise PingError(f"sweep: beams over more than {math.degrees(WIDEST_RAD):.0f} degrees in one ping")
    if ping.planes != 1 or ping.no_data:
        raise PingError("sweep: only beams of one plane, all with data, are supported")
    return sweep


def _beams_of(sweep: Sweep) -> int:
    """Return how many beams an image has."""
    span = min(sweep.bearing_max_rad - sweep.bearing_min_rad, WINDOW_RAD)
    return max(1, round(span / sweep.step_rad) + 1)


def _as_from(lines: Sequence[Line], reference: PoseEstimate | None, range_m: Floats) -> _Places:
    """Return where places on each beam are, as seen from the reference."""
    bearing = np.array([line.bearing for line in lines])
    aim = np.stack([np.cos(bearing), np.sin(bearing), np.zeros_like(bearing)], axis=-1)
    turn, away = np.tile(np.eye(3), (len(lines), 1, 1)), np.zeros((len(lines), 3))
    if reference is not None:
        back = rotation_matrix(reference.attitude).T
        for place, line in enumerate(lines):
            if line.head is not None:
                turn[place] = back @ rotation_matrix(line.head.attitude)
                away[place] = back @ (line.head.position_ned - reference.position_ned)
    points = np.einsum("lij,lj->li", turn, aim)[:, None, :] * range_m[None, :, None] + away[:, None, :]
    seen_m = np.hypot(points[..., 0], points[..., 1])
    return _Places(np.arctan2(points[..., 1], points[..., 0]), seen_m - range_m)


def _image(ping: Ping, samples: AnyArray, seen: _Places, middle: float, table: Floats) -> Ping:
    """Return the image of the samples, each cell that of the nearest beam; `table`: bearings about `middle`."""
    off = np.abs(wrap_angle(seen.bearing - middle)[:, None, :] - table[None, :, None])
    source = np.argmin(off, axis=0)
    moved = np.rint(np.take_along_axis(seen.farther_m, source, axis=0) / ping.dr_m).astype(np.intp)
    row = np.repeat(source, KNOT, axis=1)[:, : ping.samples]
    column = np.arange(ping.samples) - np.repeat(moved, KNOT, axis=1)[:, : ping.samples]
    cells = samples[row, np.clip(column, 0, ping.samples - 1)]
    step = table[1] - table[0] if len(table) > 1 else 1.0
    empty = np.flatnonzero(off.min(axis=0)[:, off.shape[2] // 2] > step)
    width = ping.beam_width_rad[0] if ping.beam_width_rad else step
    return msgspec.structs.replace(
        ping,
        beams=len(table),
        data=np.ascontiguousarray(cells).tobytes(),
        bearing_rad=table.tolist(),
        elevation_rad=[],
        beam_width_rad=[width] * len(table),
        no_data=[(beam, 0, ping.samples) for beam in empty.tolist()],
        beam_t_ns=[],
        sweep=None,
    )


def _turned(echo: Detection, middle: float) -> Detection:
    return msgspec.structs.replace(echo, bearing_rad=math.remainder(echo.bearing_rad + middle, 2.0 * math.pi))


def _place(echo: Detection, head: PoseEstimate | None) -> tuple[float, float]:
    ahead, aside = echo.range_m * math.cos(echo.bearing_rad), echo.range_m * math.sin(echo.bearing_rad)
    if head is None:
        return ahead, aside
    north, east, _ = (rotation_matrix(head.attitude) @ (ahead, aside, 0.0) + head.position_ned).tolist()
    return north, east


def _sector(swept: Swept, image: Sector) -> tuple[Sector, list[Interval]]:
    """Return all of the sector, and what of it was looked at."""
    half, sweep, looked = 0.5 * swept.sweep.step_rad, swept.sweep, swept.looked
    low, high = sweep.bearing_min_rad - half, sweep.bearing_max_rad + half
    if high - low > 2.0 * math.pi - 2.0 * half:
        low, high = -math.pi, math.pi
        seen = _wrapped(looked) if looked else []
    else:
        seen = [looked] if looked else []
        low, high = min([low, *(each.low for each in seen)]), max([high, *(each.high for each in seen)])
    return msgspec.structs.replace(image, bearing_min_rad=low, bearing_max_rad=high), seen


def _wrapped(looked: Interval) -> list[Interval]:
    """Return the same bearings from -pi to pi."""
    middle = 0.5 * (looked.low + looked.high)
    turns = middle - math.remainder(middle, 2.0 * math.pi)
    low, high = looked.low - turns, looked.high - turns
    pieces = [Interval(max(low, -math.pi), min(high, math.pi))]
    if low < -math.pi:
        pieces.append(Interval(low + 2.0 * math.pi, math.pi))
    if high > math.pi:
        pieces.append(Interval(-math.pi, high - 2.0 * math.pi))
    return sorted(pieces)


def _gaps(sector: Sector, seen: Sequence[Interval]) -> list[Interval]:
    """Return what of the sector was not looked at; `seen` in order."""
    ends = [sector.bearing_min_rad, *(border for each in seen for border in each), sector.bearing_max_rad]
    return [Interval(low, high) for low, high in zip(ends[::2], ends[1::2], strict=True) if high - low > 1e-9]


def _clipped(parts: Sequence[UnseenPart], middle: float, seen: Sequence[Interval]) -> list[UnseenPart]:
    """Return what the image could not show of what was looked at; its bearings are about `middle`."""
    found = []
    for part in parts:
        for each in seen:
            turn = middle + _turns(0.5 * (each.low + each.high) - middle)
            low, high = max(part.bearing_min_rad + turn, each.low), min(part.bearing_max_rad + turn, each.high)
            if high > low:
                found.append(msgspec.structs.replace(part, bearing_min_rad=low, bearing_max_rad=high))
    return found


def _turns(angle: float) -> float:
    """Return the whole turns that are nearest to an angle, rad."""
    return angle - math.remainder(angle, 2.0 * math.pi)
