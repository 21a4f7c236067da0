"""Objects that turn about the vehicle, or move with it, all alike: the pose drifts."""

import math

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.map.map_object import MapObject
from ods.tracker.output.common_motion import common_motion
from ods.tracker.output.snapshot import Snapshot, snapshot_of_map

CENTRE = np.array([100.0, -50.0, 5.0])
OFFSETS = np.array([[40.0, 0.0], [60.0, 20.0], [30.0, -15.0], [80.0, 5.0]]).T


def seen(velocity: Floats, sigma_mps: float = 0.1, offsets: Floats = OFFSETS) -> Snapshot:
    """Objects so far from CENTRE with these velocities, (2, n)."""
    places = offsets[:, : velocity.shape[1]] + CENTRE[:2, None]
    objects = [
        MapObject(k, (north, east, 5.0), (0.2,) * 3, 1.0, 0.1, 1.0, 9, 0, 0, 0)
        for k, (north, east) in enumerate(places.T.tolist())
    ]
    snapshot = snapshot_of_map(objects)
    snapshot.state[:] = ACTIVE
    snapshot.velocity[:2], snapshot.sigma_velocity[:2] = velocity, sigma_mps
    return snapshot


def turning(rate: float, offsets: Floats = OFFSETS) -> Floats:
    return np.array([-rate * offsets[1], rate * offsets[0]])


@pytest.mark.parametrize("rate_deg", [2.0, -2.0, 0.6])
def test_a_turn_is_found_with_its_rate_and_makes_the_list_not_valid(rate_deg: float) -> None:
    noise = np.random.default_rng(1).normal(0.0, 0.03, OFFSETS.shape)
    found = common_motion(seen(turning(math.radians(rate_deg)) + noise, 0.03), CENTRE)
    assert found is not None
    assert math.degrees(found.turn) == pytest.approx(rate_deg, abs=4.0 * math.degrees(found.sigma_turn))
    assert f"turn by {math.degrees(found.turn):.1f} +- " in found.reason()


def test_one_mover_among_five_does_not_hide_a_turn() -> None:
    places = np.concatenate([OFFSETS, [[50.0], [-30.0]]], axis=1)
    velocity = turning(math.radians(2.0), places)
    velocity[:, 2] += (0.8, -0.6)
    found = common_motion(seen(velocity, 0.05, places), CENTRE)
    assert found is not None
    assert math.degrees(found.turn) == pytest.approx(2.0, abs=0.01)


def test_three_movers_do_not_turn_about_us_by_chance() -> None:
    rng, said = np.random.default_rng(4), 0
    for _ in range(1000):
        places = np.array([rng.uniform(10.0, 90.0, 3), rng.uniform(-40.0, 40.0, 3)])
        found = common_motion(seen(rng.uniform(-1.5, 1.5, (2, 3)), 0.05, places), CENTRE)
        said += found is not None and bool(found.reason())
    assert said <= 5


def test_a_drift_of_the_place_is_a_problem_and_no_reason() -> None:
    found = common_motion(seen(np.full((2, 4), 0.5), 0.05), CENTRE)
    assert found is not None
    assert found.move == pytest.approx((0.5, 0.5))
    assert "seem to move by 0.71" in found.problem()
    assert not found.reason()


def test_objects_at_rest_two_movers_and_movers_each_its_own_way_are_none() -> None:
    noise = np.random.default_rng(2).normal(0.0, 0.05, (2, 4))
    still = common_motion(seen(noise, 0.05), CENTRE)
    assert still is None or not still.problem()
    assert common_motion(seen(turning(0.04)[:, :2]), CENTRE) is None
    for seed in range(50):
        own = np.random.default_rng(seed).uniform(-1.5, 1.5, (2, 4))
        found = common_motion(seen(own), CENTRE)
        assert found is None or not found.reason()


def test_what_is_not_finite_is_none() -> None:
    assert common_motion(seen(np.full((2, 4), math.nan)), CENTRE) is None
