"""The planner's rule: it fires for what comes near, in time, and not for young tracks of what rests far away."""

import math

import msgspec
import numpy as np
import pytest

from ods.base.clock import NS
from ods.client import near_misses
from ods.messages import Obstacle, ObstacleList, PoseAt, Sector
from ods.tracker.measurement.scan import Scan, Vehicle, echoes_of
from ods.tracker.output.closest_approach import Course
from ods.tracker.output.obstacle_list import ObstacleLister
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker
from tests.client.test_ahead import MOVING, T_NS

RATE_HZ = 5.0
SECTOR = Sector(0.0, 120.0, -math.radians(45.0), math.radians(45.0), math.radians(10.0))
SIGMA_RANGE, SIGMA_BEARING = 0.1, math.radians(0.5)
RESTING = msgspec.structs.replace(
    MOVING, position_ned=(40.0, 0.0, 9.0), velocity_ned=(0.0, 0.0, 0.0), sigma_position=(0.3, 0.4, 3.0),
    sigma_velocity=(0.0, 0.0, 0.0), covariance_ne=0.0, radius_m=1.0,
)  # fmt: skip


def seen_from(
    *obstacles: Obstacle, velocity: tuple[float, float] = (0.0, 0.0), place: tuple[float, float] = (0.0, 0.0)
) -> ObstacleList:
    """Return a list of a vehicle at `place` with a velocity, north and east."""
    pose = PoseAt((*place, 9.0), (1.0, 0.0, 0.0, 0.0), (*velocity, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    return ObstacleList(0, 0, T_NS, T_NS, T_NS, True, [], list(obstacles), pose=pose)


def readmes_former_rule(obstacle: Obstacle) -> bool:
    return obstacle.cpa is not None and obstacle.cpa.distance_m - 2.0 * obstacle.cpa.sigma_m < 5.0


def followed(
    run: int, start: tuple[float, float], velocity: tuple[float, float], seconds: float, course: Course
) -> list[ObstacleList]:
    """Return the lists of a vehicle at the origin while an object goes on from `start`."""
    rng, tracker = np.random.default_rng([29, run]), Tracker(TrackerSettings())
    settings = tracker.settings
    lister = ObstacleLister(settings.planner, settings.motion, settings.bottom)
    vehicle, lists = Vehicle(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3)), []
    for k in range(round(seconds * RATE_HZ)):
        north, east = (p + v * k / RATE_HZ for p, v in zip(start, velocity, strict=True))
        row = np.array([[math.hypot(north, east), math.atan2(east, north), 0.0, 1.0, SIGMA_RANGE, SIGMA_BEARING, 0.3]])
        row[0, :2] += np.array([SIGMA_RANGE, SIGMA_BEARING]) * rng.standard_normal(2)
        t_ns = round(k / RATE_HZ * NS)
        tracker.step(Scan(t_ns, t_ns, vehicle, SECTOR, echoes_of(row)[0]))
        reported = lister.obstacles(tracker.snapshot(), course)
        lists.append(msgspec.structs.replace(seen_from(*reported), t_ns=t_ns))
    return lists


AT_REST = Course(np.zeros(3), np.zeros(3))


def test_objects_that_rest_40_m_away_do_not_come_near_however_young_their_tracks_are() -> None:
    """The rule that the README had took what a velocity of half a second may make of 300 s."""
    lists = [
        each
        for run in range(40)
        for each in followed(run, (40.0 * math.cos(0.01 * run), 40.0 * math.sin(0.01 * run)), (0.0, 0.0), 8.0, AT_REST)
    ]
    pairs = [(each, obstacle) for each in lists for obstacle in each.obstacles]
    fired = sum(readmes_former_rule(obstacle) for _, obstacle in pairs)
    print(f"{len(pairs)} pairs, the former rule fires for {fired / len(pairs):.1%}")
    assert fired > 0.05 * len(pairs)
    assert [each for each in lists if near_misses(each, 5.0, 60.0)] == []


@pytest.mark.parametrize("speed", [0.5, 1.5])
def test_what_comes_straight_on_is_said_early_enough(speed: float) -> None:
    """A second's way before it is there, at the least, and soon after it is known at all."""
    for run in range(10):
        lists = followed(run, (40.0, 3.0), (-speed, 0.0), 12.0, AT_REST)
        arrives_s = (40.0 - math.sqrt(6.0**2 - 3.0**2)) / speed
        warned = [each for each in lists if near_misses(each, 5.0, 120.0)]
        assert warned, run
        assert warned[0].t_ns / NS < arrives_s - 15.0
        (miss,) = near_misses(lists[-1], 5.0, 120.0)
        assert miss.time_s <= arrives_s - lists[-1].t_ns / NS


@pytest.mark.parametrize(
    ("velocity", "place", "horizon_s", "time_s"),
    [
        ((2.0, 0.0), (0.0, 0.0), 60.0, (40.0 - 1.0 - 5.0 - 2.0 * math.hypot(0.3, 0.1)) / 2.0),  # straight at it
        ((2.0, 0.0), (0.0, 0.0), 15.0, None),  # beyond the horizon
        ((2.0, 0.0), (0.0, 10.0), 60.0, None),  # abeam at 9 m
        ((-2.0, 0.0), (0.0, 0.0), 60.0, None),  # away from it
        ((0.0, 0.0), (36.0, 0.0), 60.0, 0.0),  # beside it
    ],
)
def test_closed_forms_of_what_rests(
    velocity: tuple[float, float], place: tuple[float, float], horizon_s: float, time_s: float | None
) -> None:
    found = near_misses(seen_from(RESTING, velocity=velocity, place=place), 5.0, horizon_s)
    if time_s is None:
        assert found == []
    else:
        (miss,) = found
        assert time_s <= miss.time_s <= time_s + 1.0  # looked at once a second


def test_what_lies_on_a_fast_vehicles_way_is_met_even_between_the_times_looked_at() -> None:
    small = msgspec.structs.replace(RESTING, position_ned=(37.0, 0.4, 9.0), sigma_position=(0.01, 0.01, 3.0))
    (miss,) = near_misses(seen_from(small, velocity=(10.0, 0.0)), 0.1)
    assert miss.time_s <= 3.7
    assert miss.distance_m == pytest.approx(-0.6)


def test_the_course_of_a_young_track_is_carried_on_for_ten_times_its_age_only() -> None:
    coming = msgspec.structs.replace(
        RESTING, velocity_ned=(-1.0, 0.0, 0.0), sigma_velocity=(0.1, 0.1, 0.0), first_seen_utc_ns=0
    )
    ages = {1: 0, 2: 0, 4: 1}
    for age_s, fires in ages.items():
        aged = msgspec.structs.replace(coming, last_seen_utc_ns=age_s * NS)
        assert len(near_misses(seen_from(aged), 5.0)) == fires, age_s


def test_the_soonest_comes_first_and_what_ended_not_at_all() -> None:
    near = msgspec.structs.replace(RESTING, id=8, position_ned=(20.0, 0.0, 9.0))
    gone = msgspec.structs.replace(near, id=9, state="terminated")
    found = near_misses(seen_from(RESTING, near, gone, velocity=(1.0, 0.0)), 5.0)
    assert [each.obstacle.id for each in found] == [8, 7]


def test_without_a_pose_nothing_is_taken_for_far_away() -> None:
    alone = msgspec.structs.replace(seen_from(RESTING), pose=None)
    (miss,) = near_misses(alone, 5.0)
    assert (miss.obstacle, miss.time_s) == (RESTING, 0.0)


def test_what_an_operator_said_to_ignore_is_no_near_miss() -> None:
    near = msgspec.structs.replace(RESTING, position_ned=(3.0, 0.0, 9.0))
    assert [each.obstacle.id for each in near_misses(seen_from(near), 5.0)] == [near.id]
    assert near_misses(seen_from(msgspec.structs.replace(near, ignored_by=0)), 5.0) == []
