"""What an echogram shows over its levels: echoes, tracks and true objects in range; faults of images and lists."""

from collections.abc import Iterator, Sequence
from itertools import groupby

import msgspec
import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.base.frames.geometry import body_to_polar, rotation_matrix
from ods.tracker.output.obstacle_list import NAMES
from ods.workbench.engine.echogram.levels import Echogram
from ods.workbench.engine.mission.tracked import Course, Tracked, TrueCourse

MOST_VALUES = 500
"""Of a line."""
TRUTH = "truth"


class Echoes(msgspec.Struct, frozen=True):
    """Detections: of those that would lie in one cell of the echogram the first."""

    place: Sequence[int]
    """Of the ping in the data."""
    range_m: Sequence[float]


class Way(msgspec.Struct, frozen=True):
    """How the range of an object went, while it had one state."""

    role: str
    """A state of tracks, or TRUTH."""
    id: str
    """Of the track; empty: none."""
    label: str
    place: Sequence[int]
    range_m: Sequence[float | None]
    """None interrupts the line."""

    @property
    def is_seen(self) -> bool:
        """Whether any of it is in the fan."""
        return any(far_m is not None for far_m in self.range_m)


class Span(msgspec.Struct, frozen=True):
    """Pings of which the same is to be said."""

    first: int
    stop: int
    """The place after the last; as `first`: something is missing before it."""
    why: str


class Layers(msgspec.Struct, frozen=True):
    """All that lies over the levels."""

    echoes: Echoes = Echoes([], [])
    tracks: Sequence[Way] = ()
    truths: Sequence[Way] = ()
    faults: Sequence[Span] = ()
    """Drop-outs, parts of images that are not seen, bad and missing pings."""
    invalid: Sequence[Span] = ()
    """Lists that a planner must not trust."""


def layers_of(result: Tracked, echogram: Echogram, beam: int | None) -> Layers:
    """Return what a tracked mission says over an echogram of one beam, or of all."""
    sight = _Sight(result, echogram, beam)
    return Layers(
        _echoes(result, echogram, sight),
        [way for course in result.courses for way in _ways(course, result.name_of(course.id), sight) if way.is_seen],
        [way for truth in result.truths if (way := _true_way(result, truth, sight)).is_seen],
        sorted([*spans(result.log.fault), *_missing(result.log.number)], key=lambda span: span.first),
        spans(result.log.invalid),
    )


def spans(why: Sequence[str]) -> list[Span]:
    """Return the runs of pings with the same reason, of which there is one."""
    found, place = [], 0
    for reason, run in groupby(why):
        stop = place + len(list(run))
        found += [Span(place, stop, reason)] if reason else []
        place = stop
    return found


def _missing(number: Ints) -> Iterator[Span]:
    """Yield where numbers of pings are left out."""
    for place in (np.flatnonzero(np.diff(number) > 1) + 1).tolist():
        count = int(number[place] - number[place - 1]) - 1
        yield Span(place, place, f"{count} ping{'s' * (count > 1)} missing")


class _Sight:
    """What lies in the fan, or in the one beam that is shown, as the sonar's head sees it."""

    def __init__(self, result: Tracked, echogram: Echogram, beam: int | None) -> None:
        attitude = np.array(result.attitude, np.float64).reshape(-1, 4)
        self._head, turn = result.mounting.heads(result.path, attitude)
        self._turn = rotation_matrix(turn)
        bearings = echogram.bearing_rad if beam is None else echogram.bearing_rad[beam : beam + 1]
        half = echogram.half_beam_rad
        self._left, self._right = -np.inf, -np.inf
        if len(bearings):
            self._left, self._right = float(bearings[0]) - half, float(bearings[-1]) + half
        self._is_beam = beam is not None

    def holds(self, range_m: Floats, bearing_rad: Floats, radius_m: Floats | float) -> Mask:
        """Tell what is shown: of all beams what has its centre in them, of one beam what reaches into it."""
        across = np.arcsin(np.clip(radius_m / np.maximum(range_m, 1e-9), 0.0, 1.0)) if self._is_beam else 0.0
        return np.asarray((bearing_rad >= self._left - across) & (bearing_rad <= self._right + across))

    def way(self, role: str, identity: str, label: str, place: Ints, position: Floats, radius_m: Floats | float) -> Way:
        """Return the slant range of places, (k, 3) NED, at pings."""
        body = np.einsum("ki,kij->kj", position - self._head[place], self._turn[place])
        range_m, bearing, _ = body_to_polar(body)
        shown = self.holds(range_m, bearing, radius_m)
        gaps = np.flatnonzero(np.diff(place) > 1)
        some = np.unique(np.concatenate([_evenly(len(place)), gaps, np.flatnonzero(np.diff(shown)) + 1]))
        shown[gaps] = False
        told = zip(range_m[some].tolist(), shown[some].tolist(), strict=True)
        return Way(
            role, identity, label, place[some].tolist(), [round(far_m, 3) if seen else None for far_m, seen in told]
        )


def _evenly(count: int) -> Ints:
    return np.unique(np.linspace(0, max(0, count - 1), min(count, MOST_VALUES)).astype(np.int64))


def _ways(course: Course, name: str, sight: _Sight) -> Iterator[Way]:
    """Yield a track's way, a line for each of its states."""
    for span in course.lives():
        rows = (course.t_s >= span.from_s) & (course.t_s <= span.to_s)
        state = NAMES.get(span.state, "terminated")
        if state != "terminated" and rows.any():
            yield sight.way(state, str(course.id), name, course.place[rows], course.position[rows], course.radius[rows])


def _true_way(result: Tracked, truth: TrueCourse, sight: _Sight) -> Way:
    place = np.searchsorted(result.t_s, truth.t_s - 1e-6)
    return sight.way(TRUTH, "", truth.name, place, truth.position, truth.radius_m)


def _echoes(result: Tracked, echogram: Echogram, sight: _Sight) -> Echoes:
    log = result.log
    shown = np.flatnonzero(sight.holds(log.echo_range_m, log.echo_bearing_rad, log.echo_radius_m))
    place, range_m = log.echo_place[shown], log.echo_range_m[shown]
    cell = (range_m / echogram.cell_m).astype(np.int64)
    _, first = np.unique(np.stack([place // echogram.per_column, cell]), axis=1, return_index=True)
    first.sort()
    return Echoes(place[first].tolist(), np.round(range_m[first], 3).tolist())
