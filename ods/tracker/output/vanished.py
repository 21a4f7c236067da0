"""Have the static objects in view vanished together? Then the image is another one, with its sides exchanged, its rows
mixed up, its bits lost, its ranges or bearings off; or the objects are not where they are listed.

One object may hide behind another, or leave the fan above or below it. Most of those that nearly every ping has shown
do not do so within a second, unless the fan tilts or sinks away from them.
"""

import math
from collections import deque
from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

from ods.base.clock import NS
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.measurement.scan import Scan, Vehicle
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import REST

PINGS = 6
"""Number of pings in a row by which an object is judged: first as steady, then as gone."""
STEADY, GONE = 5, 2
"""Of so many pings an object that is steady gives this many echoes at least, and one that is gone this many at most."""
MOST = 64
"""Number of objects that are looked at."""
FEWEST, SHARE = 3, 0.6
"""Number of objects that must vanish, and their share of those that are steady."""
WITHIN_S = 3.0
"""Time within which they do, s: longer than PINGS last with slow pings, nothing is certain."""
EDGE = 0.05
"""Share of the fan at each side in which an object may not be seen."""
TILT_SHARE = 0.25
"""Share of the fan's vertical opening by which it may tilt or sink without losing an object."""
HELD_S = 5.0
"""Time for which it is reported after they have vanished, and until others are steady, but no longer than"""
LONGEST_S = 30.0


class _Look(NamedTuple):
    """What a snapshot says of an object."""

    times_seen: int
    unseen_s: float
    position: list[float]
    """North, east, m."""


@dataclass(slots=True)
class _Object:
    """A static object, and in which of the last pings that should have shown it it was seen."""

    look: _Look
    head: Vehicle
    """When it was seen last."""
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


class VanishedObjects:
    """Takes what each ping showed of the tracked objects."""

    def __init__(self) -> None:
        self.begin_again()

    def begin_again(self) -> None:
        """Forget all: poses are others."""
        self._objects: dict[int, _Object] = {}
        self._t_s = -math.inf
        self._vanished, self._since_s = "", 0.0

    def look(self, snapshot: Snapshot, scan: Scan) -> None:
        """Take in a ping: the objects after it, and its sector."""
        t_s, vehicle = scan.t_ns / NS, scan.vehicle
        if vehicle is None or not scan.usable or scan.skipped_pings:
            return
        if t_s - self._t_s > WITHIN_S / PINGS:  # so seldom that much may have changed
            self._objects.clear()
        self._t_s = t_s
        self._count(snapshot, scan, vehicle)
        gone = sum(each.is_gone for each in self._objects.values())
        steady = sum(each.was_steady for each in self._objects.values())
        if gone >= max(FEWEST, SHARE * steady):
            self._vanished, self._since_s = f"{gone} of {steady} static objects are not seen any more", t_s
        elif t_s - self._since_s > LONGEST_S or (t_s - self._since_s > HELD_S and self._sees_others()):
            self._vanished = ""

    def forget(self, number: int) -> None:
        """Expect an object no more: an operator has dropped it."""
        self._objects.pop(number, None)

    def reasons(self) -> list[str]:
        """Return why the list is not valid for it."""
        return [f"{self._vanished} where they were: is the image another one, or the pose?"] if self._vanished else []

    def _sees_others(self) -> bool:
        return any(each.is_steady for each in self._objects.values())

    def _count(self, snapshot: Snapshot, scan: Scan, vehicle: Vehicle) -> None:
        """Note which objects were seen, of those that should have been, and forget those in other places."""
        columns = snapshot.id, snapshot.times_seen, snapshot.unseen_s, snapshot.position[:2].T
        listed = {number: _Look(*rest) for number, *rest in zip(*(column.tolist() for column in columns), strict=True)}
        for number, each in list(self._objects.items()):
            look = listed.get(number, each.look)
            if look.times_seen > each.look.times_seen:
                each.hits.append(True)
                each.head = vehicle
            elif look.unseen_s == each.look.unseen_s:
                each.hits.append(False)
            each.look = look
            if not _should_be_seen(each, scan, vehicle):
                del self._objects[number]
        usable = (snapshot.state == ACTIVE) & (snapshot.static >= REST)
        for number in snapshot.id[usable].tolist():
            if number not in self._objects and len(self._objects) < MOST:
                self._objects[number] = _Object(listed[number], vehicle)


def _should_be_seen(each: _Object, scan: Scan, vehicle: Vehicle) -> bool:
    """Return whether an object is well within the fan, and the fan at the height at which it saw it last."""
    sector, forward = scan.sector, vehicle.rotation[:2, 0]
    north, east = each.look.position[0] - vehicle.position[0], each.look.position[1] - vehicle.position[1]
    range_m = math.hypot(north, east)
    bearing = math.remainder(math.atan2(east, north) - math.atan2(forward[1], forward[0]), 2.0 * math.pi)
    side, depth = EDGE * (sector.bearing_max_rad - sector.bearing_min_rad), EDGE * sector.range_max_m
    if not sector.bearing_min_rad + side < bearing < sector.bearing_max_rad - side:
        return False
    if not sector.range_min_m + depth < range_m < sector.range_max_m - depth:
        return False
    tilt = math.acos(min(1.0, float(each.head.rotation[:, 2] @ vehicle.rotation[:, 2])))
    sunk = abs(float(vehicle.position[2] - each.head.position[2])) / range_m
    return tilt + sunk < TILT_SHARE * 2.0 * sector.half_vertical_rad
