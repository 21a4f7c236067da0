"""The all-knowing arm: its motions are the vehicle's, and its way is the shortest that there is."""

import math

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.missions.all_knowing.motions import VehicleCommands, motion_of, moved
from ods.missions.all_knowing.search import CLOSER_M, EAGER, PathQuery, fastest_path
from ods.missions.flight import Flight
from ods.missions.settings import Campaign, WorldSettings
from ods.missions.world import World
from ods.offline.mission import MissionSettings
from ods.planner.settings import SteeringSettings
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.settings import VehicleSettings
from ods.sim_sonar.steered import SteeredVehicle, at_start

CAN = VehicleSettings()
CURRENT = (0.1, -0.2)


def query(
    *obstacles: tuple[float, float, float], moving: tuple[float, float] = (0.0, 0.0), keep_m: float = 0.9
) -> PathQuery:
    """Return the way to a goal 80 m north, among obstacles (north, east, radius), at 2 m/s from the start on."""
    rows = np.array(obstacles, np.float64).reshape(-1, 3)

    def places(t_s: float) -> Floats:
        return np.asarray(rows[:, :2] + t_s * np.array(moving))

    start = at_start(0.0, 2.0)
    return PathQuery(start, (80.0, 0.0), 5.0, places, rows[:, 2], keep_m, CAN, (2.0, 1.0), (0.0, 0.0), 0.05, 1, 200.0)


def test_motions_are_those_of_the_simulated_vehicle() -> None:
    start = at_start(0.3, 1.0, (5.0, -4.0, 20.0))
    one = SteeredVehicle(CAN, start, CURRENT)
    many = motion_of(start)
    for heading, speed in ((0.5, 2.0), (-2.9, 2.0), (3.0, 1.0), (0.0, 9.0)):
        one.obey(heading, speed, 20.0)
        for _ in range(40):
            one.step(0.0375)
        many, places = moved(many, VehicleCommands(np.array([heading]), np.array([speed])), CAN, CURRENT, 0.0375, 40)
    now = one.way[-1]
    assert [float(each[0]) for each in many] == pytest.approx(
        [now.north_m, now.east_m, now.heading_rad, now.speed_m_s, now.turn_rad_s], abs=1e-9
    )
    assert places[-1, 0].tolist() == pytest.approx([now.north_m, now.east_m], abs=1e-9)


def test_with_nothing_in_the_way_it_goes_straight() -> None:
    way = fastest_path(query())
    assert way is not None
    assert way.path_m == pytest.approx(75.0, abs=0.15)


def test_round_a_disc_it_is_as_short_as_two_tangents_and_an_arc() -> None:
    """Of a circle of 11 m in the middle of 80 m; the goal counts as reached 5 m before, on the tangent."""
    way = fastest_path(query((40.0, 0.0, 10.0 - CLOSER_M), keep_m=1.0))
    assert way is not None
    r, half = 11.0, 40.0
    shortest = 2.0 * math.sqrt(half**2 - r**2) + r * (math.pi - 2.0 * math.acos(r / half)) - 5.0
    assert 0.999 * shortest < way.path_m < 1.02 * EAGER * shortest
    assert np.hypot(*(way.places - (40.0, 0.0)).T).min() > r - CLOSER_M


def test_it_knows_where_what_moves_will_be() -> None:
    """Where one crosses its way at the time that it comes there, it goes by, and hardly longer."""
    crossing = query((40.0, -20.0, 3.0), moving=(0.0, 1.0))
    way = fastest_path(crossing)
    assert way is not None
    t_s = np.arange(len(way.places)) * 0.05
    away = np.hypot(way.places[:, 0] - 40.0, way.places[:, 1] + 20.0 - t_s)
    assert away.min() > 3.9
    assert way.path_m < 1.03 * 75.0


def test_where_there_is_no_way_it_says_so() -> None:
    ring = [(20.0 + 6.0 * math.cos(a), 6.0 * math.sin(a), 2.0) for a in np.arange(16) * math.pi / 8]
    assert fastest_path(query(*ring)._replace(goal_m=(20.0, 0.0), reached_m=1.0, most_s=14.0)) is None


def test_the_arm_flies_what_was_found() -> None:
    settings = WorldSettings(length_m=80.0, width_m=40.0, obstacles_per_hectare=0.0)
    campaign = Campaign(seed=1, world=settings, planner=SteeringSettings(reached_m=5.0))
    world = World(
        settings, np.array([(40.0, -14.0), (60.0, 0.0)]), np.array([(0.0, 0.6), (0.0, 0.0)]), np.array([3.0, 2.0]),
        CURRENT, 5,
    )  # fmt: skip
    flown = Flight(campaign, 0, "all_knowing", find_sonar("seabat6012"), MissionSettings(), world)
    outcome = flown.fly()
    assert (outcome.ending, outcome.evasions, outcome.near_miss) == ("success", 0, False)
    assert outcome.clearance_m == pytest.approx(1.1, abs=0.3)
    end = flown.vehicle.way[-1]
    assert math.hypot(80.0 - end.north_m, end.east_m) <= 5.0
