"""Are the static objects in view still where nearly every ping has shown them?

If most are missing at once, the image is another one (its sides exchanged, its rows mixed up, its ranges or bearings
off), or the pose is wrong. One object may hide behind another, or leave the fan above or below it; most do not do so
within a second, unless the fan tilts or sinks away from them. Where one change of all ranges or bearings puts them at
echoes, two pings suffice to be certain, and it is known whether the change lasts.
"""

import math
from collections import deque
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.base.clock import NS
from ods.tracker.common_error.causes import FEWEST, SURELY
from ods.tracker.common_error.least_squares import FAST_MEMORY_S
from ods.tracker.common_error.sightings import LARGEST_M, LEAST_SIGMA_RAD, REACH_M
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.measurement.scan import Scan, Vehicle
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import REST

PINGS = 6
"""Number of pings in a row by which an object is judged: first as steady, then as gone."""
STEADY, GONE = 5, 2
"""Of so many pings an object that is steady gives this many echoes at least, and one that is gone this many at most."""
MOST = 32
"""Number of objects, or echoes, that are looked at."""
SHARE = 0.6
"""Of the objects that are steady this share must vanish, or be displaced."""
GATE_M = 0.5
"""An echo is an object's if ranges differ by less, and bearings by `SURELY` standard deviations."""
MORE_THAN_STILL = 2.0
"""Ratio of the number of objects that agree with a change to that of those that agree with none."""
FEWEST_ECHOES = 5
"""Number of echoes that must be displaced where there are no static objects: of some clutter they may be by chance."""
MOVERS = 2.0
"""Ratio by which movers may be farther from where they were: 2 m/s at 7 pings a second."""
WITHIN_S = 3.0
"""Time within which objects vanish, s: longer than PINGS last with slow pings, nothing is certain."""
EDGE = 0.05
"""Share of the fan at each side in which an object may not be seen."""
TILT_SHARE = 0.25
"""Share of the fan's vertical opening by which it may tilt or sink without losing an object."""
HELD_S = 5.0
"""Time for which it is reported after they have vanished, and until others are steady, but no longer than"""
LONGEST_S = 30.0
TURNED, MIRRORED = "bearings, or the heading, have changed by {:+.1f} deg", "port and starboard are exchanged"
LONGER, SCALED = "ranges have changed by {:+.1f} m", "ranges have changed by {:+.1%}"


class _Observation(NamedTuple):
    """What a snapshot says of an object."""

    times_seen: int
    unseen_s: float
    position: list[float]
    """North, east, m."""


class _Place(NamedTuple):
    """Where a static object was,"""

    position: list[float]
    """north, east, m,"""
    head: Vehicle
    """and the sonar's head when it was seen last."""


@dataclass(slots=True)
class _Object:
    """A static object, where it was in the last pings that should have shown it, and which of them did."""

    look: _Observation
    place: _Place
    places: deque[_Place] = field(default_factory=lambda: deque(maxlen=2 * PINGS))
    hits: deque[bool] = field(default_factory=lambda: deque(maxlen=2 * PINGS))

    @property
    def was_steady(self) -> bool:
        """Return whether the earlier pings saw it."""
        return len(self.hits) == 2 * PINGS and sum(islice(self.hits, PINGS)) >= STEADY

    @property
    def is_steady(self) -> bool:
        """Return whether the later pings saw it."""
        return sum(islice(reversed(self.hits), PINGS)) >= STEADY

    @property
    def is_gone(self) -> bool:
        """Return whether it was steady, and the later pings did not see it."""
        return self.was_steady and sum(islice(reversed(self.hits), PINGS)) <= GONE

    def take_in(self, look: _Observation, vehicle: Vehicle, *, covered: bool) -> None:
        """Take in what a ping showed of it; covered: an echo, such as of a whole wall, has its place."""
        hit = look.times_seen > self.look.times_seen
        self.place = _Place(look.position, vehicle if hit else self.place.head)
        if hit or (look.unseen_s == self.look.unseen_s and not covered):
            self.hits.append(hit)
            self.places.append(self.place)
        self.look = look


class _Expected(NamedTuple):
    """Where objects were lately."""

    places: list[_Place]
    reach_m: float = REACH_M
    """They may be so far from there now."""
    fewest: int = FEWEST
    """So many at least must be displaced."""


class _Change(NamedTuple):
    """One change that puts objects at echoes."""

    agree: int
    """Number of them."""
    words: str
    size: float
    gate: float
    """What differs by less is the same change."""

    def is_like(self, other: "_Change | None") -> bool:
        """Return whether another ping shows the same one."""
        return other is not None and self.words == other.words and abs(self.size - other.size) < self.gate


class DisplacedObjects:
    """Takes what each ping showed of the tracked objects."""

    def __init__(self) -> None:
        self._objects: dict[int, _Object] = {}
        self._t_s = -math.inf
        self._why, self._since_s = "", -math.inf
        self._changes: deque[_Change | None] = deque(maxlen=PINGS)
        self._before: list[_Place] = []
        """Where objects were before a change that lasts."""
        self._scans: deque[Scan] = deque(maxlen=PINGS)

    def look(self, snapshot: Snapshot, scan: Scan, *, moving: bool = False) -> None:
        """Take in a ping: the objects after it, and its echoes; moving: all seem to move alike, so that a change lasts
        although nothing of before is in view."""
        t_s, vehicle = scan.t_ns / NS, scan.vehicle
        if vehicle is None or not scan.usable or scan.skipped_pings:
            return
        if t_s - self._t_s > WITHIN_S / PINGS:  # so seldom that much may have changed
            self._objects.clear()
        self._t_s = t_s
        self._count(snapshot, scan, vehicle)
        steady = [each for each in self._objects.values() if each.was_steady]
        if self._finds_change(steady, scan, vehicle):
            self._since_s = t_s
        elif t_s - self._since_s > HELD_S and not (self._before and moving):
            self._before = []
            self._find_vanished(steady)
        self._scans.append(scan)

    def _expected(self, steady: list[_Object]) -> _Expected:
        """Return where objects were lately.

        Where nothing is static, as while all turns or alternates, these are the echoes of a moment ago, some of movers.
        """
        if self._before:
            return _Expected(self._before)
        if len(steady) >= FEWEST:
            return _Expected([each.places[PINGS] for each in steady])
        lately = (_places_of(each) for each in self._scans if self._t_s - each.t_ns / NS <= FAST_MEMORY_S)
        return _Expected(next(lately, []), MOVERS * REACH_M, FEWEST_ECHOES)

    def _finds_change(self, steady: list[_Object], scan: Scan, vehicle: Vehicle) -> bool:
        """Return whether there is a change: two of PINGS pings show it, as it may come and go."""
        expected = self._expected(steady)
        places = [each for each in expected.places if _should_be_seen(each, scan, vehicle)]
        change = _change(expected._replace(places=places), scan, vehicle)
        found = change is not None and any(change.is_like(other) for other in self._changes)
        self._changes.append(change)
        if change is None or not found:
            return False
        if change.words != TURNED:  # which may be a heading that is corrected: then the new places are right
            self._before = self._before or places
        what = change.words.format(change.size)
        self._why = f"{change.agree} of {len(places)} objects are seen elsewhere at once: {what}"
        return True

    def _find_vanished(self, steady: list[_Object]) -> None:
        gone = sum(each.is_gone for each in steady)
        if gone >= max(FEWEST, SHARE * len(steady)):
            self._why = f"{gone} of {len(steady)} static objects have vanished where they were"
            self._since_s = self._t_s
        elif self._t_s - self._since_s > LONGEST_S or any(each.is_steady for each in self._objects.values()):
            self._why = ""

    def forget(self, number: int) -> None:
        """Expect an object no more: an operator has dropped it."""
        self._objects.pop(number, None)

    def reasons(self) -> list[str]:
        """Return why the list is not valid for it."""
        return [f"{self._why}: is the image another one, or the pose?"] if self._why else []

    @property
    def are_in_place(self) -> bool:
        """Return whether enough static objects show that ranges and bearings are as before."""
        return sum(each.is_steady for each in self._objects.values()) >= FEWEST

    def _count(self, snapshot: Snapshot, scan: Scan, vehicle: Vehicle) -> None:
        """Note which objects were seen, of those that should have been, and forget those in other places."""
        columns = snapshot.id, snapshot.times_seen, snapshot.unseen_s, snapshot.position[:2].T
        listed = {
            number: _Observation(*rest) for number, *rest in zip(*(each.tolist() for each in columns), strict=True)
        }
        for number, each in list(self._objects.items()):
            each.take_in(listed.get(number, each.look), vehicle, covered=_is_covered(each.place, scan, vehicle))
            if not _should_be_seen(each.place, scan, vehicle):
                del self._objects[number]
        usable = (snapshot.state == ACTIVE) & (snapshot.static >= REST)
        for number in snapshot.id[usable].tolist():
            if number not in self._objects and len(self._objects) < MOST:
                look = listed[number]
                self._objects[number] = _Object(look, _Place(look.position, vehicle))


def _places_of(scan: Scan) -> list[_Place]:
    """Return the places of the echoes of small objects, of not more than MOST, one a place; none without a pose."""
    rows, vehicle = scan.echoes.rows, scan.vehicle
    if vehicle is None:
        return []
    north, east = vehicle.rotation[:2, 0]
    small = np.flatnonzero(rows.radius < LARGEST_M)
    small = small[:: len(small) // MOST + 1]
    azimuth = math.atan2(east, north) + rows.bearing[small]
    places = vehicle.position[:2] + (rows.range_m[small] * np.array([np.cos(azimuth), np.sin(azimuth)])).T
    near = np.hypot(*(places[:, None] - places).T) < REACH_M
    return [_Place(place, vehicle) for place in places[~np.triu(near, 1).any(axis=0)].tolist()]


def _polar(place: _Place, vehicle: Vehicle) -> tuple[float, float]:
    """Return range and bearing of a place from the head."""
    north, east = place.position[0] - vehicle.position[0], place.position[1] - vehicle.position[1]
    azimuth, heading = math.atan2(east, north), math.atan2(vehicle.rotation[1, 0], vehicle.rotation[0, 0])
    return math.hypot(north, east), math.remainder(azimuth - heading, 2.0 * math.pi)


def _wrapped(angles: Floats) -> Floats:
    return np.remainder(angles + np.pi, 2.0 * np.pi) - np.pi


def _change(expected: _Expected, scan: Scan, vehicle: Vehicle) -> _Change | None:
    """Return the one change of all ranges or bearings that puts most objects at echoes; None if most are seen where
    they are, or no change does."""
    places, rows = expected.places, scan.echoes.take(np.flatnonzero(scan.echoes.rows.radius < LARGEST_M)).rows
    range_m, bearing = np.array([_polar(each, vehicle) for each in places]).reshape(-1, 2).T[:, :, None]
    longer, turn = rows.range_m - range_m, _wrapped(rows.bearing - bearing)
    still = (np.hypot(longer, range_m * turn) < expected.reach_m).any(axis=1)
    wanted = max(expected.fewest, SHARE * len(places), MORE_THAN_STILL * np.count_nonzero(still))
    if wanted > len(places):
        return None
    gate = SURELY * np.maximum(rows.sigma_bearing, LEAST_SIGMA_RAD)
    near, aligned = np.abs(longer) < GATE_M, np.abs(turn) < gate
    near[still] = aligned[still] = False
    mirrored = near & (np.abs(_wrapped(rows.bearing + bearing)) < gate)
    changes = [
        _most_alike(TURNED, near, np.degrees(turn), np.degrees(gate)),
        _most_alike(MIRRORED, mirrored, np.zeros_like(turn), gate),
        _most_alike(LONGER, aligned, longer, np.full_like(range_m, GATE_M)),
        _most_alike(SCALED, aligned, longer / range_m, GATE_M / range_m),
    ]
    best = max(changes, key=lambda each: each.agree)
    return best if best.agree >= wanted else None


def _most_alike(words: str, possible: Mask, size: Floats, gate: Floats) -> _Change:
    """Return the size of a change with which most objects agree; all are (n, m), of n objects and m echoes."""
    of, by = pairs = possible.nonzero()
    sizes, gates = size[pairs], np.broadcast_to(gate, size.shape)[pairs]
    if not len(of):
        return _Change(0, words, 0.0, 0.0)
    agree = np.abs(sizes[:, None] - sizes) < gates[:, None]
    counts = np.minimum(_different(agree, of), _different(agree, by))
    best = int(counts.argmax())
    return _Change(int(counts[best]), words, float(np.median(sizes[agree[best]])), float(gates[best]))


def _different(agree: Mask, rows: Ints) -> Ints:
    """Return how many different rows each of k pairs agrees with, of (k, k) and those of each pair."""
    own = (rows[:, None] == np.unique(rows)).astype(np.float32)
    counts: Ints = np.count_nonzero(agree.astype(np.float32) @ own, axis=1)
    return counts


def _is_covered(place: _Place, scan: Scan, vehicle: Vehicle) -> bool:
    """Return whether a place lies in the circle of an echo, as that of a piece of a wall in that of the whole."""
    (range_m, bearing), echoes = _polar(place, vehicle), scan.echoes.rows
    away = range_m * np.exp(1j * (bearing - echoes.bearing)) - echoes.range_m
    return bool((np.abs(away) < echoes.radius).any())


def _should_be_seen(place: _Place, scan: Scan, vehicle: Vehicle) -> bool:
    """Return whether an object is well within the fan, and the fan at the height at which it saw it last."""
    sector, (range_m, bearing) = scan.sector, _polar(place, vehicle)
    side, depth = EDGE * (sector.bearing_max_rad - sector.bearing_min_rad), EDGE * sector.range_max_m
    if not sector.bearing_min_rad + side < bearing < sector.bearing_max_rad - side:
        return False
    if not sector.range_min_m + depth < range_m < sector.range_max_m - depth:
        return False
    tilt = math.acos(min(1.0, float(place.head.rotation[:, 2] @ vehicle.rotation[:, 2])))
    sunk = abs(float(vehicle.position[2] - place.head.position[2])) / range_m
    return tilt + sunk < TILT_SHARE * 2.0 * sector.half_vertical_rad
