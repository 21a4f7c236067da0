"""Static objects that are elsewhere at once, or vanish together, are reported whatever has happened to the image."""

import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest

from ods.base.frames.geometry import quat_from_euler
from ods.tracker.common_error.displaced import HELD_S, LONGEST_S, DisplacedObjects
from ods.tracker.measurement.scan import Scan, vehicle_at
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import HALF_FOV, NO_SIGMA, RANGE_MAX_M, RATE_HZ, SECTOR, echoes

Rows = list[tuple[float, float]]
PLACES = [(50.0, -12.0), (56.0, 9.0), (62.0, -20.0), (70.0, 16.0), (75.0, -3.0)]
"""North, east, m."""
FAULT_S = 6.0
Sees = Callable[[Rows], Rows]


class Rig:
    """A vehicle that goes north past static objects; each ping shows what `sees` makes of their ranges and bearings."""

    def __init__(self, places: Rows = PLACES) -> None:
        self.tracker, self.displaced = Tracker(TrackerSettings()), DisplacedObjects()
        self.places = places
        self.number, self.north, self.speed = 0, 0.0, 1.0
        self.pitch, self.usable, self.moving = 0.0, True, False
        self.radius_m = 1.0

    def sail(self, seconds: float, sees: Callable[[Rows], Rows] = list) -> list[float]:
        """Return the times, since the call, of the pings with which something is reported."""
        reported = []
        begun = self.number
        while self.number - begun < seconds * RATE_HZ:
            self._ping(sees)
            if self.displaced.reasons():
                reported.append((self.number - begun) / RATE_HZ)
        return reported

    def _ping(self, sees: Callable[[Rows], Rows]) -> None:
        t_s = self.number / RATE_HZ
        self.number += 1
        self.north += self.speed / RATE_HZ
        polar = [(math.hypot(n - self.north, e), math.atan2(e, n - self.north)) for n, e in self.places]
        rows = [(r, b, self.radius_m) for r, b in sees(polar) if r < RANGE_MAX_M and abs(b) < HALF_FOV]
        attitude = quat_from_euler(0.0, self.pitch, 0.0)
        vehicle = vehicle_at(np.array([self.north, 0.0, 4.0]), attitude, NO_SIGMA, NO_SIGMA)
        scan = Scan(round(t_s * 1e9), round(t_s * 1e9), vehicle, SECTOR, echoes(rows), self.usable)
        self.tracker.step(scan)
        self.displaced.look(self.tracker.snapshot(), scan, moving=self.moving)


def nothing(_: Rows) -> Rows:
    return []


def mirrored(rows: Rows) -> Rows:
    return [(r, -b) for r, b in rows]


def shifted_by_five_metres(rows: Rows) -> Rows:
    return [(r + 5.0, b) for r, b in rows]


def ten_percent_longer(rows: Rows) -> Rows:
    return [(1.1 * r, b) for r, b in rows]


def turned_by_eight_degrees(rows: Rows) -> Rows:
    return [(r, b + math.radians(8.0)) for r, b in rows]


ELSEWHERE: list[tuple[Sees, str]] = [
    (mirrored, "port and starboard are exchanged"), (shifted_by_five_metres, "ranges have changed by +5.0 m"),
    (ten_percent_longer, "ranges have changed by +10.0%"),
    (turned_by_eight_degrees, "bearings, or the heading, have changed by +8.0 deg"),
]  # fmt: skip


@pytest.mark.parametrize("speed", [0.0, 1.0])
@pytest.mark.parametrize(("sees", "change"), ELSEWHERE)
def test_objects_that_are_elsewhere_at_once_are_reported_by_two_pings_with_the_change(
    sees: Sees, change: str, speed: float
) -> None:
    rig = Rig()
    rig.speed = speed
    assert rig.sail(FAULT_S) == []
    reported = rig.sail(HELD_S, sees)
    assert reported[0] == pytest.approx(2.0 / RATE_HZ)
    assert len(reported) == pytest.approx((HELD_S - reported[0]) * RATE_HZ, abs=2)  # without a gap
    (reason,) = rig.displaced.reasons()
    assert f"5 objects are seen elsewhere at once: {change}" in reason


def test_pieces_that_are_seen_as_one_large_echo_have_not_vanished() -> None:
    """A wall in view becomes short enough to be one echo."""
    rig = Rig()
    rig.sail(FAULT_S)
    rig.radius_m = 30.0
    assert rig.sail(LONGEST_S / 2.0, lambda rows: [(float(np.mean([r for r, _ in rows])), 0.0)]) == []


@pytest.mark.parametrize("sees", [mirrored, shifted_by_five_metres, ten_percent_longer])
def test_it_is_reported_while_it_lasts(sees: Sees) -> None:
    rig = Rig()
    rig.speed = 0.0
    rig.sail(FAULT_S)
    assert rig.sail(2.0 * LONGEST_S, sees)[-1] == pytest.approx(2.0 * LONGEST_S)
    assert rig.sail(10.0)[-1] == pytest.approx(HELD_S, abs=0.2)


@pytest.mark.parametrize("moving", [False, True])
def test_a_change_lasts_without_objects_of_before_while_all_seem_to_move(moving: bool) -> None:
    rig = Rig()
    rig.sail(FAULT_S)
    rig.sail(1.0, ten_percent_longer)
    rig.places, rig.moving = [(n + 80.0, e) for n, e in PLACES], moving
    rig.north += 80.0
    assert (rig.sail(10.0, ten_percent_longer)[-1] == 10.0) == moving


def test_after_a_step_of_the_heading_the_new_places_may_be_the_right_ones() -> None:
    rig = Rig()
    rig.speed = 0.0
    rig.sail(FAULT_S)
    assert HELD_S < rig.sail(20.0, turned_by_eight_degrees)[-1] < HELD_S + 2.0


@pytest.mark.parametrize("begun", [0.0, FAULT_S])
@pytest.mark.parametrize("every", [2, 3])
def test_ranges_that_alternate_are_reported(every: int, begun: float) -> None:
    turns = itertools.count()
    rig = Rig()
    rig.sail(begun)
    reported = rig.sail(20.0, lambda rows: rows if next(turns) % every else ten_percent_longer(rows))
    assert reported[0] < (2.0 if begun == 0.0 else 1.1)
    assert reported[-1] == pytest.approx(20.0)


def test_objects_that_vanish_together_are_reported_within_a_second() -> None:
    rig = Rig()
    assert rig.sail(FAULT_S) == []
    reported = rig.sail(HELD_S, nothing)
    assert 0.3 < reported[0] <= 1.0
    assert reported[-1] == pytest.approx(HELD_S, abs=0.2)  # without a gap
    (reason,) = rig.displaced.reasons()
    assert "5 of 5 static objects have vanished where they were" in reason


@pytest.mark.parametrize("velocity", [(0.9, 0.3), (-0.2, 0.8), (0.0, -1.5)])
def test_movers_alike_are_not_elsewhere_at_once(velocity: tuple[float, float]) -> None:
    rig = Rig()

    def move(rows: Rows) -> Rows:
        rig.places = [(n + velocity[0] / RATE_HZ, e + velocity[1] / RATE_HZ) for n, e in rig.places]
        return rows

    assert rig.sail(15.0, move) == []


def test_it_is_reported_until_others_are_seen_and_no_longer_than_half_a_minute() -> None:
    rig = Rig()
    rig.sail(FAULT_S)
    assert rig.sail(HELD_S + 2.0, nothing)[-1] > HELD_S + 1.0
    rig.places = [(n + 25.0, e) for n, e in PLACES]
    rig.sail(4.0)
    assert not rig.displaced.reasons()

    rig = Rig()
    rig.sail(FAULT_S)
    assert LONGEST_S < rig.sail(LONGEST_S + 5.0, nothing)[-1] < LONGEST_S + 3.0


def test_echoes_that_fail_now_and_then_and_one_object_that_hides_are_nothing() -> None:
    rng = np.random.default_rng(1)
    rig = Rig()
    assert rig.sail(10.0, lambda rows: [row for row in rows if rng.random() < 0.9]) == []
    assert rig.sail(10.0, lambda rows: rows[1:]) == []


def test_objects_that_an_operator_drops_do_not_vanish() -> None:
    rig = Rig()
    rig.sail(FAULT_S)
    for number in rig.tracker.snapshot().id.tolist()[:4]:
        rig.tracker.forget(number)
        rig.displaced.forget(number)
    assert rig.sail(5.0, lambda rows: rows[4:]) == []


def test_objects_that_leave_the_fan_do_not_vanish() -> None:
    rig = Rig([(north - 30.0, east) for north, east in PLACES])
    assert rig.sail(60.0) == []


@pytest.mark.parametrize("degrees", [-15.0, 15.0])
def test_a_vehicle_that_dives_or_climbs_loses_them_by_itself(degrees: float) -> None:
    rig = Rig()
    rig.sail(FAULT_S)
    rig.pitch = math.radians(degrees)
    assert rig.sail(5.0, nothing) == []


def test_images_that_show_nothing_are_reported_elsewhere() -> None:
    rig = Rig()
    rig.sail(FAULT_S)
    rig.usable = False
    assert rig.sail(5.0, nothing) == []


def test_with_slow_pings_nothing_is_certain() -> None:
    rig = Rig()
    rig.sail(FAULT_S)
    rig.number += round(RATE_HZ)
    assert rig.sail(1.0, mirrored) == []
