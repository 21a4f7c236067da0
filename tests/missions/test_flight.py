"""One mission in the loop: what the referee sees, and arms in the same world."""

import math
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from ods.base.errors import OdsError
from ods.missions.failing.errors import ErrorSettings
from ods.missions.flight import Flight
from ods.missions.settings import Arm, Campaign, WorldSettings
from ods.missions.setup import flight_of, setup_of
from ods.missions.watch import OnBoard, TruthWatch
from ods.missions.world import World
from ods.offline.mission import MissionSettings
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.sea_bed.settings import Roughness, SeaBed
from ods.sim_sonar.settings import VehicleSettings

WORLD = WorldSettings(length_m=80.0, width_m=40.0, obstacles_per_hectare=0.0, current_m_s=0.0)
ROUGH = Roughness(rms_height_m=0.15, correlation_m=3.0)


def flight(
    arm: Arm, *obstacles: tuple[float, float, float], moving: tuple[float, float] = (0.0, 0.0), **more: Any
) -> Flight:
    """Return a mission among obstacles (north, east, radius)."""
    campaign = Campaign(seed=1, world=WORLD, **more)
    return Flight(campaign, 0, arm, find_sonar("seabat6012"), MissionSettings(), world_of(*obstacles, moving=moving))


def world_of(*obstacles: tuple[float, float, float], moving: tuple[float, float] = (0.0, 0.0)) -> World:
    rows = np.array(obstacles, np.float64).reshape(-1, 3)
    return World(WORLD, rows[:, :2], np.tile(moving, (len(rows), 1)), rows[:, 2], (0.0, 0.0), 5)


def test_without_avoidance_it_collides_where_the_obstacle_is() -> None:
    flown = flight("none", (50.0, 0.5, 2.0))
    outcome = flown.fly()
    assert outcome.ending == "collision"
    assert not outcome.near_miss
    edge = 50.0 - math.sqrt((2.0 + 0.5) ** 2 - 0.5**2)
    assert flown.vehicle.way[-1].north_m == pytest.approx(edge, abs=0.3)
    assert outcome.clearance_m is not None
    assert -0.3 < outcome.clearance_m < 0.0
    assert outcome.path_m == pytest.approx(edge, abs=0.3)


def test_a_near_miss_is_no_collision_and_what_moves_may_hit() -> None:
    assert flight("none", (50.0, 3.0, 2.0)).fly().near_miss
    assert flight("none", (50.0, 3.0, 2.0)).fly().ending == "success"
    assert flight("none", (40.0, -10.0, 1.0), moving=(0.0, 0.45)).fly().ending == "collision"


def test_in_open_water_it_arrives_without_evasion() -> None:
    outcome = flight("truth").fly()
    assert (outcome.ending, outcome.evasions, outcome.clearance_m) == ("success", 0, None)
    assert outcome.path_m == pytest.approx(70.0, abs=0.5)


def test_with_the_truth_as_list_it_keeps_its_distance() -> None:
    outcome = flight("truth", (50.0, 0.5, 2.0)).fly()
    assert (outcome.ending, outcome.evasions_of_nothing) == ("success", 0)
    assert outcome.clearance_m is not None
    assert outcome.clearance_m > 2.0
    assert outcome.evasions > 0


def test_it_gives_up_in_time() -> None:
    outcome = flight("none", longest=1.0, vehicle=VehicleSettings(most_m_s=1.5)).fly()
    assert outcome.ending == "time-out"
    assert outcome.time_s == pytest.approx(40.0, abs=0.2)


def test_an_evasion_of_nothing_is_reported_from_others() -> None:
    """It is reported of an obstacle where there is none, and of the one that there is."""
    there = (60.0, 0.5, 1.0)
    flown = flight("truth", there)
    assert flown.fly().evasions_of_nothing == 0
    deceived = flight("ods", (60.0, 30.0, 1.0))
    deceived.watch = TruthWatch(world_of((50.0, 0.5, 2.0)), 100.0)
    outcome = deceived.fly()
    assert outcome.evasions == outcome.evasions_of_nothing > 0


@pytest.mark.slow
def test_with_the_list_of_pipeline_and_tracker_it_passes_what_it_would_hit() -> None:
    """The obstacle is found where it is, the start is not valid, and the same again is the same."""
    flown = flight("ods", (50.0, 0.5, 2.0))
    for ping in range(90):
        flown.step(ping)
    assert flown.received is not None
    (found,) = flown.received.list.obstacles
    assert math.dist(found.position_ned[:2], (50.0, 0.5)) < 1.0
    outcome = flight("ods", (50.0, 0.5, 2.0)).fly()
    assert (outcome.ending, outcome.near_miss, outcome.evasions_of_nothing) == ("success", False, 0)
    assert 0.0 < outcome.not_valid_s < 3.0
    assert flight("ods", (50.0, 0.5, 2.0)).fly() == outcome


def test_a_3d_sonar_sends_range_images_of_the_same_world() -> None:
    """What is ahead is in reach first at 15 m."""
    campaign = Campaign(seed=1, world=WORLD, sonar="sonar3d15")
    flown = flight_of(campaign, 0, "ods", setup_of(campaign), world_of((30.0, 0.5, 2.0)))
    assert isinstance(flown.watch, OnBoard)
    for ping in range(150):
        flown.step(ping)
        if flown.received is not None and flown.received.list.obstacles:
            break
    assert flown.received is not None
    (found,) = flown.received.list.obstacles
    edge_m = math.dist(found.position_ned[:2], flown.vehicle.way[-1].place[:2]) - found.radius_m
    assert 12.0 < edge_m < 15.0
    assert math.dist(found.position_ned[:2], (30.0, 0.5)) < 2.0


@pytest.mark.parametrize(
    ("more", "reported"),
    [
        ({"world": replace(WORLD, sea_bed=SeaBed(depth_m=27.0, rough=ROUGH))}, "needs an even sea-bed"),
        ({"errors": ErrorSettings(range_scale=1.05)}, "errors: .*range images"),
    ],
)
def test_what_range_images_are_not_simulated_with_is_refused(more: dict[str, Any], reported: str) -> None:
    campaign = Campaign(seed=1, sonar="sonar3d15", **more)
    with pytest.raises(OdsError, match=reported):
        flight_of(campaign, 0, "ods", setup_of(campaign))


def test_time_to_collision_is_of_what_it_would_run_into_when_it_was_listed_first() -> None:
    """At 1 m/s, after one ping of 0.15 s; what passes 4 m aside or goes away is none."""
    flown = flight("truth", (30.0, 0.5, 2.0), (20.0, 6.5, 2.0))
    flown.step(0)
    gone_m = flown.vehicle.way[-1].north_m
    edge_m = 30.0 - math.sqrt(2.5**2 - 0.5**2)
    assert flown.referee.time_to_collision_s == pytest.approx(edge_m - gone_m, abs=1e-6)
    away = flight("truth", (30.0, 0.5, 2.0), moving=(1.5, 0.0))
    away.step(0)
    assert away.referee.time_to_collision_s == math.inf


def test_what_was_never_listed_left_no_time() -> None:
    unseen = flight("ods", (50.0, 0.5, 2.0))
    unseen.watch = TruthWatch(world_of(), 100.0)
    outcome = unseen.fly()
    assert (outcome.ending, outcome.time_to_collision_s) == ("collision", 0.0)
    assert flight("none", (50.0, 0.5, 2.0)).fly().time_to_collision_s is None
