"""Random worlds: one each for a seed and a number, and how near a place is to what is in it."""

import math

import numpy as np
import pytest

from ods.missions.settings import WorldSettings
from ods.missions.world import World, make_world

SETTINGS = WorldSettings(length_m=200.0, width_m=100.0, obstacles_per_hectare=20.0, moving_share=0.5)


def alike(one: World, other: World) -> bool:
    return one.seed == other.seed and np.array_equal(one.start_m, other.start_m)


def test_a_number_makes_one_world_and_no_other_number_or_seed_makes_it_too() -> None:
    """[5, 1] as a seed with a number after it would be 2**32 + 5 with the same number, and number 0 no number."""
    worlds = [make_world(SETTINGS, seed, number) for seed in (5, 2**32 + 5, 6) for number in (0, 1, 7)]
    assert alike(make_world(SETTINGS, 5, 7), worlds[2])
    for place, one in enumerate(worlds):
        assert not any(alike(one, other) for other in worlds[:place])


def test_obstacles_are_as_the_settings_say() -> None:
    worlds = [make_world(SETTINGS, 1, number) for number in range(100)]
    start, velocity = np.vstack([world.start_m for world in worlds]), np.vstack([world.velocity for world in worlds])
    radius = np.concatenate([world.radius_m for world in worlds])
    speed = np.hypot(*velocity.T)
    taken = (0.5 * math.pi * 31.5**2 + 0.5 * math.pi * 16.5**2) / 1e4  # free of obstacles, by the mean radius
    assert len(start) == pytest.approx(100 * 20.0 * (2.0 - taken), rel=0.06)
    assert np.mean(speed > 0.0) == pytest.approx(0.5, abs=0.05)
    assert (speed[speed > 0.0].min() >= 0.2, speed.max() <= 1.0) == (True, True)
    assert (radius.min() >= 0.5, radius.max() <= 2.5) == (True, True)
    assert (start.min(axis=0) >= (0.0, -50.0)).all()
    assert (start.max(axis=0) <= (200.0, 50.0)).all()
    assert (np.hypot(*start.T) - radius).min() >= 30.0
    assert (np.hypot(*(start - (200.0, 0.0)).T) - radius).min() >= 15.0
    assert max(math.hypot(*world.current_m_s) for world in worlds) <= 0.3


def test_clearances_are_those_of_the_nearest_of_many_points() -> None:
    world = make_world(SETTINGS, 3, 0)
    angle, height = np.meshgrid(np.radians(np.arange(0.0, 360.0, 0.5)), np.arange(-10.0, 10.01, 0.5))
    t_s = 12.0
    for north, east, down in ((100.0, 3.0, 20.0), (100.0, 3.0, 6.0), (140.0, -20.0, 33.0)):
        got = world.clearances(t_s, north, east, down)
        for which in (0, 5, 9):
            axis = world.start_m[which] + t_s * world.velocity[which]
            radius = world.radius_m[which]
            points = np.stack([axis[0] + radius * np.cos(angle), axis[1] + radius * np.sin(angle), 20.0 + height], -1)
            nearest = np.linalg.norm(points - (north, east, down), axis=-1).min()
            assert got[which] == pytest.approx(nearest, abs=0.05)


def test_over_an_obstacle_there_is_room_and_inside_there_is_none() -> None:
    world = make_world(SETTINGS, 3, 0)
    north, east = world.start_m[0].tolist()
    assert world.clearances(0.0, north, east, 20.0)[0] < 0.0
    assert world.clearances(0.0, north, east, 5.0)[0] == pytest.approx(5.0)
