"""What of a pose's error is noise is measured; the rest is a bias, and does not blur what the pings agree in."""

import math

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.geometry import quat_from_euler
from ods.messages import Sector
from ods.tracker.measurement.pose_noise import PoseNoise
from ods.tracker.measurement.scan import Scan, Vehicle, echoes_of, vehicle_at
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

PERIOD_NS = round(0.15 * NS)


def posed(place: Floats, yaw: float, sigma_m: float, sigma_yaw: float = 0.01) -> Vehicle:
    attitude = np.array(quat_from_euler(0.0, 0.0, yaw))
    found = vehicle_at(place, attitude, np.array([sigma_m, sigma_m, 0.1]), np.array([0.002, 0.002, sigma_yaw]))
    assert found is not None
    return found


@pytest.mark.parametrize("steady", [True, False])
def test_noise_is_measured_and_the_rest_of_the_claim_is_bias(steady: bool) -> None:
    rng, noise, split = np.random.default_rng(4), PoseNoise(), posed(np.zeros(3), 0.0, 1.0)
    t_ns, sizes = 0, (0.12, 0.04, 0.006)
    for _ in range(400):
        t_ns += PERIOD_NS if steady else round(PERIOD_NS * rng.uniform(0.5, 1.5))
        off = np.append(rng.normal(0.0, sizes[:2]), 0.0)
        place = np.array([1.5, -0.5, 0.0]) * t_ns / NS + off
        yaw = math.radians(170.0 + 5.0 * t_ns / NS) + rng.normal(0.0, sizes[2])  # passes south, where yaw wraps
        split = noise.take(posed(place, math.remainder(yaw, math.tau), 0.15), t_ns)
    assert split.bias == pytest.approx(np.sqrt(np.array([0.15, 0.15, 0.01]) ** 2 - np.array(sizes) ** 2), rel=0.2)


@pytest.mark.parametrize(
    ("off_m", "claimed_m", "expected_m"), [(0.0, 0.1, 0.1), (0.0, 5.0, 0.3), (1.0, 5.0, 1.0), (2.0, 0.1, 0.1)]
)
def test_what_counts_as_noise_is_measured_but_at_least_a_third_of_a_metre_and_at_most_the_claim(
    off_m: float, claimed_m: float, expected_m: float
) -> None:
    rng, noise, split = np.random.default_rng(1), PoseNoise(), posed(np.zeros(3), 0.0, 0.1)
    for k in range(300):
        split = noise.take(posed(off_m * rng.standard_normal(3), 0.0, claimed_m), k * PERIOD_NS)
    assert split.noise == pytest.approx([expected_m] * 2, rel=0.2)
    assert (split.bias >= 0.0).all()


def test_a_gap_or_a_clock_that_steps_back_is_compared_with_nothing() -> None:
    noise = PoseNoise()
    for k in range(50):
        noise.take(posed(np.array([0.3 * k, 0.0, 0.0]), 0.0, 5.0), k * PERIOD_NS)
    for t_ns in (60 * NS, 60 * NS, 1):
        split = noise.take(posed(np.array([1e3, t_ns, 0.0]), 0.0, 5.0), t_ns)
        assert split.noise[0] == 0.3


def places_of(sigma_m: float, bodies: Floats) -> tuple[Floats, Floats]:
    """Return places (2, n) and standard deviations (2, n) of what was tracked of bodies (2, n) for 9 s."""
    rng, tracker = np.random.default_rng(7), Tracker(TrackerSettings())
    sector = Sector(0.0, 100.0, -0.8, 0.8, 0.1)
    for k in range(60):
        place = np.array([0.15 * k, 0.0, 0.0])
        north, east = bodies - place[:2, None]
        count = bodies.shape[1]
        rows = np.zeros((count, 7))
        rows[:, 0] = np.hypot(north, east) + rng.normal(0.0, 0.1, count)
        rows[:, 1] = np.arctan2(east, north) + rng.normal(0.0, 0.01, count)
        rows[:, 3:] = 0.5, 0.1, 0.01, 0.2
        tracker.step(Scan(k * PERIOD_NS, k * PERIOD_NS, posed(place, 0.0, sigma_m), sector, echoes_of(rows)[0]))
    found = tracker.snapshot()
    order = np.argsort(found.position[1])
    return found.position[:2, order], found.sigma_position[:2, order]


def test_dead_reckoning_that_is_ten_metres_off_keeps_objects_apart_and_where_they_are() -> None:
    """As under water: the vehicle's place may be wrong by 10 m, and the objects with it, but not one another."""
    bodies = np.array([[60.0, 60.0, 62.0, 60.0], [-6.0, -2.5, 1.0, 5.0]])
    exact, _ = places_of(0.1, bodies)
    found, sigma = places_of(10.0, bodies)
    assert found.shape == bodies.shape
    assert np.abs(found - bodies).max() < 0.5
    assert np.abs(found - exact).max() < 0.1
    assert (sigma >= 10.0).all()
