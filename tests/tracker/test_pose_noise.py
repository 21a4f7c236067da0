"""What of a pose's error is noise is measured; the rest is a bias, and does not blur what the pings agree in."""

import math

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.geometry import quat_from_euler
from ods.messages import Sector
from ods.tracker.measurement.pose.pose_noise import UNSURE, PoseNoise
from ods.tracker.measurement.scan import Scan, Vehicle, echoes_of, vehicle_at
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

PERIOD_NS = round(0.15 * NS)


def posed(
    place: Floats, yaw: float, sigma_m: float, sigma_yaw: float = 0.01, tilt: tuple[float, float] = (0.0, 0.0)
) -> Vehicle:
    attitude = np.array(quat_from_euler(tilt[0], tilt[1], yaw))
    found = vehicle_at(place, attitude, np.array([sigma_m, sigma_m, 0.1]), np.array([0.002, 0.002, sigma_yaw]))
    assert found is not None
    return found


@pytest.mark.parametrize("steady", [True, False])
def test_noise_is_measured_and_what_is_surely_more_of_the_claim_is_bias(steady: bool) -> None:
    rng, noise = np.random.default_rng(4), PoseNoise()
    t_ns, sizes, found = 0, (0.12, 0.04, 0.006), []
    for _ in range(2000):
        t_ns += PERIOD_NS if steady else round(PERIOD_NS * rng.uniform(0.5, 1.5))
        off = np.append(rng.normal(0.0, sizes[:2]), 0.0)
        place = np.array([1.5, -0.5, 0.0]) * t_ns / NS + off
        yaw = math.radians(170.0 + 5.0 * t_ns / NS) + rng.normal(0.0, sizes[2])  # passes south, where yaw wraps
        tilt = rng.normal(0.0, 0.001), rng.normal(0.0, 0.004)
        found.append(noise.take(posed(place, math.remainder(yaw, math.tau), 0.15, tilt=tilt), t_ns))
    surely = np.array(sizes) ** 2 * (1.0 + UNSURE / 10.0)  # of 100 pings, by `FORGETTING`
    bias = np.sqrt(np.mean([np.square(one.bias) for one in found[500:]], axis=0))
    assert bias == pytest.approx(np.sqrt(np.array([0.15, 0.15, 0.01]) ** 2 - surely), rel=0.2)
    assert np.mean([one.noise[2] for one in found[500:]]) == pytest.approx(0.004, rel=0.1)


def test_a_claim_that_is_all_noise_is_not_bias_too() -> None:
    """Of an error that is new with every ping, what the measurement is unsure of must not be claimed once more."""
    rng, noise = np.random.default_rng(5), PoseNoise()
    found = [noise.take(posed(rng.normal(0.0, 0.1, 3), 0.0, 0.1), k * PERIOD_NS).bias[:2] for k in range(2000)]
    assert np.sqrt(np.mean(np.square(found[500:]))) < 0.015


@pytest.mark.parametrize(
    ("off_m", "claimed_m", "expected_m"), [(0.0, 0.1, 0.1), (0.0, 5.0, 0.3), (1.0, 5.0, 1.0), (2.0, 0.1, 0.1)]
)
def test_what_counts_as_noise_is_measured_but_at_least_a_third_of_a_metre_and_at_most_the_claim(
    off_m: float, claimed_m: float, expected_m: float
) -> None:
    rng, noise, split = np.random.default_rng(1), PoseNoise(), posed(np.zeros(3), 0.0, 0.1)
    for k in range(300):
        split = noise.take(posed(off_m * rng.standard_normal(3), 0.0, claimed_m), k * PERIOD_NS)
    assert split.noise[:2] == pytest.approx([expected_m] * 2, rel=0.2)
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


def looked_at(tilt_deg: float, seed: int) -> Floats:
    """Return how much too far (6,) bodies at the vehicle's depth are after 30 s, where its tilt is noisy, unclaimed."""
    tracker = Tracker(TrackerSettings())
    sector = Sector(0.0, 100.0, -0.8, 0.8, math.radians(10.0))
    distance, bearing = np.linspace(40.0, 90.0, 6), np.linspace(-0.6, 0.6, 6)
    noise, tilts = np.random.default_rng(seed + 1), np.random.default_rng(seed + 2)
    for k in range(200):
        rows = np.zeros((6, 7))
        rows[:, 0] = distance + noise.normal(0.0, 0.1, 6)
        rows[:, 1] = bearing + noise.normal(0.0, 0.01, 6)
        rows[:, 3:] = 0.5, 0.1, 0.01, 0.2
        tilt = math.radians(tilt_deg) * tilts.standard_normal(), math.radians(tilt_deg) * tilts.standard_normal()
        vehicle = posed(np.zeros(3), 0.0, 0.1, tilt=tilt)
        tracker.step(Scan(k * PERIOD_NS, k * PERIOD_NS, vehicle, sector, echoes_of(rows)[0]))
    found = tracker.snapshot()
    return np.asarray(np.sort(np.hypot(*found.position[:2])) - distance)


def test_noise_of_the_tilt_is_not_taken_for_another_look_at_the_height() -> None:
    """Once it was: bodies were put where their range allows at a height that nothing had shown."""
    still = np.mean([np.square(looked_at(0.0, seed)) for seed in range(3)])
    noisy = np.mean([np.square(looked_at(0.2, seed)) for seed in range(3)])
    assert math.sqrt(noisy) < 2.0 * math.sqrt(still)
