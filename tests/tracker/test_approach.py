"""Closest point of approach and predictions: closed forms, brute force over time, the filter's own prediction."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.base.arrays import Floats
from ods.messages import ClosestApproach, Obstacle
from ods.tracker.existence import lifecycle
from ods.tracker.output.closest_approach import Course, closest_approach
from ods.tracker.output.obstacle_list import ObstacleLister
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import BottomSettings, MotionSettings, PlannerSettings
from tests.tracker import axis

STILL = MotionSettings(acceleration_noise=0.0, static_noise=0.0)
HORIZON_S = 300.0
AT_REST = Course(np.zeros(3), np.zeros(3))


def objects(position: list[list[float]], velocity: list[list[float]], radius: float = 1.0) -> Snapshot:
    """Return (n, 3) positions and velocities as a picture of active objects with errors that differ by axis."""
    n = len(position)
    ids = np.arange(1, n + 1)
    return Snapshot(
        id=ids,
        state=np.full(n, lifecycle.ACTIVE),
        position=np.array(position, np.float64).T,
        velocity=np.array(velocity, np.float64).T,
        radius=np.full(n, radius),
        sigma_position=np.tile([[0.3], [0.4], [3.0]], n),
        covariance_ne=np.zeros(n),
        sigma_velocity=np.tile([[0.1], [0.2], [0.3]], n),
        sigma_radius=np.full(n, 0.2),
        existence=np.full(n, 0.9),
        static=np.zeros(n),
        times_seen=ids,
        first_seen_utc_ns=ids,
        last_seen_utc_ns=ids,
        unseen_s=np.zeros(n),
        restless=np.zeros(n),
    )


@pytest.mark.parametrize(
    ("position", "velocity", "vehicle", "time_s", "distance"),
    [
        ([40.0, 3.0, 9.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0], 20.0, 2.0),  # at rest, passed abeam
        ([30.0, 40.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.0, 49.0),  # nothing moves
        ([0.0, 20.0, 0.0], [1.5, 0.5, 0.0], [1.5, 0.5, 0.7], 0.0, 19.0),  # parallel courses
        ([-40.0, 3.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0], 0.0, np.hypot(40.0, 3.0) - 1.0),  # behind
        ([50.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 25.0, -1.0),  # head on, through its middle
        ([0.6, 0.0, 0.0], [0.0, 0.0, 0.0], [0.1, 0.0, 0.0], 6.0, -1.0),  # inside already
        ([1000.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], HORIZON_S, 699.0),  # beyond the horizon
        ([10.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1e-200, 0.0, 0.0], HORIZON_S, 9.0),  # a speed whose square is 0
    ],
)
def test_closed_forms(
    position: list[float], velocity: list[float], vehicle: list[float], time_s: float, distance: float
) -> None:
    course = Course(np.zeros(3), np.array(vehicle))
    approach = closest_approach(objects([position], [velocity]), course, STILL, HORIZON_S)
    assert approach.time_s[0] == pytest.approx(time_s)
    assert approach.distance_m[0] == pytest.approx(distance)


VECTORS = st.lists(st.floats(-200.0, 200.0, allow_subnormal=False), min_size=3, max_size=3)
SPEEDS = st.lists(st.floats(-4.0, 4.0, allow_subnormal=False), min_size=3, max_size=3)


@given(position=VECTORS, velocity=SPEEDS, vehicle=SPEEDS, place=VECTORS)
def test_no_other_time_is_nearer(
    position: list[float], velocity: list[float], vehicle: list[float], place: list[float]
) -> None:
    """Brute force: at 3001 instants of the horizon the distance is never less, and at the time told it is as told."""
    now = objects([position], [velocity])
    approach = closest_approach(now, Course(np.array(place), np.array(vehicle)), STILL, HORIZON_S)
    told = float(approach.time_s[0])
    assert 0.0 <= told <= HORIZON_S

    def distance(t: Floats) -> Floats:
        apart = np.subtract(position, place)[:2, None] + np.subtract(velocity, vehicle)[:2, None] * t
        return np.asarray(np.hypot(*apart) - 1.0)

    nearest = float(approach.distance_m[0])
    assert nearest == pytest.approx(float(distance(np.array([told]))[0]), abs=1e-9)
    assert nearest <= float(distance(np.linspace(0.0, HORIZON_S, 3001)).min()) + 1e-9
    assert np.isfinite(approach.sigma_m).all()


def test_the_uncertainty_of_the_distance_is_what_sampling_shows() -> None:
    """Correlated errors of the place, at the time of the closest approach: against a hundred thousand samples."""
    rng = np.random.default_rng(3)
    now = replace(objects([[60.0, 20.0, 0.0]], [[0.0, 0.0, 0.0]]), covariance_ne=np.array([0.08]))
    now = replace(now, sigma_velocity=np.zeros((3, 1)), static=np.ones(1))
    course = Course(np.zeros(3), np.array([1.0, 1.0, 0.0]))
    approach = closest_approach(now, course, STILL, HORIZON_S)
    samples = rng.multivariate_normal([60.0, 20.0], [[0.3**2, 0.08], [0.08, 0.4**2]], 100_000)
    offset = samples - float(approach.time_s[0]) * course.velocity[:2]
    spread = np.hypot(np.std(np.hypot(*offset.T)), 0.2)
    assert approach.sigma_m[0] == pytest.approx(spread, rel=0.01)


@pytest.mark.parametrize("bearing", [0.0, 0.5, np.pi / 4.0, 2.0])
@pytest.mark.parametrize(
    ("radial", "across"),
    [
        (0.0, 0.0),  # it seems to rest: before, told as sure as its place is, 0.4 instead of 15 to 22 m
        (0.01, 0.05),  # to fall behind, slowly
        (0.0, -0.5),  # to pass abeam just now
        (0.3, 0.0),  # to fall behind for sure
        (-0.5, 0.2),  # and to come nearer
    ],
)
def test_what_may_come_nearer_although_it_seems_not_to_is_told(bearing: float, radial: float, across: float) -> None:
    """Errors of place and velocity apart from each other, against a hundred thousand samples."""
    rng, horizon_s, sigma_v = np.random.default_rng(3), 200.0, 0.1
    towards, abeam = np.array([np.cos(bearing), np.sin(bearing)]), np.array([-np.sin(bearing), np.cos(bearing)])
    place, velocity = 60.0 * towards, radial * towards + across * abeam
    now = objects([[*place, 0.0]], [[*velocity, 0.0]])
    now = replace(now, sigma_position=np.full((3, 1), 0.3), sigma_velocity=np.full((3, 1), sigma_v))
    approach = closest_approach(now, AT_REST, STILL, horizon_s)
    places = place + 0.3 * rng.standard_normal((100_000, 2))
    drifts = velocity + sigma_v * rng.standard_normal((100_000, 2))
    closing = np.clip(-(places * drifts).sum(axis=1) / (drifts**2).sum(axis=1), 0.0, horizon_s)
    nearest = np.hypot(*(places + drifts * closing[:, None]).T) - 1.0
    error = np.hypot(np.sqrt(np.mean((nearest - approach.distance_m[0]) ** 2)), 0.2)
    assert 0.6 * error < approach.sigma_m[0] < 1.6 * error


@given(
    slope=st.floats(-1.0, 3.0),
    variance=st.floats(1e-4, 10.0),
    residual=st.floats(1e-6, 1.0),
    noise=st.floats(0.0, 0.1),
    dt=st.floats(0.0, 60.0),
)
def test_a_prediction_is_never_surer_than_the_filter(
    slope: float, variance: float, residual: float, noise: float, dt: float
) -> None:
    now = objects([[0.0, 0.0, 0.0]], [[1.0, 1.0, 1.0]])
    state = axis.axis(0.0, 1.0, variance, slope, residual)
    speed_sigma = np.full((3, 1), state.velocity_variance() ** 0.5)
    now = replace(now, sigma_position=np.full((3, 1), variance**0.5), sigma_velocity=speed_sigma)
    filtered = axis.predict(state, dt, noise)
    later = now.extrapolated(dt, MotionSettings(acceleration_noise=noise))
    assert (later.sigma_position[:, 0] >= np.sqrt(filtered.variance) * (1.0 - 1e-9)).all()
    np.testing.assert_allclose(later.position[:, 0], filtered.position[0], atol=1e-9)


def test_the_list_tells_approach_and_predictions() -> None:
    lister = ObstacleLister(
        PlannerSettings(shape_sigma=0.0, lead_times_s=(1.0, 4.0), announce_ended=1), STILL, BottomSettings()
    )
    now = objects([[40.0, 3.0, 9.0], [0.0, 50.0, 9.0]], [[0.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
    first, second = lister.obstacles(now, Course(np.zeros(3), np.array([2.0, 0.0, 0.0])))
    assert first.cpa is not None
    assert (first.cpa.time_s, first.cpa.distance_m) == pytest.approx((20.0, 2.0))
    assert [p.lead_s for p in second.predicted] == [1.0, 4.0]
    assert second.predicted[1].position_ned == pytest.approx((0.0, 46.0, 9.0))
    assert second.predicted[1].sigma_position == pytest.approx((0.3 + 0.4, 0.4 + 0.8, 3.0 + 1.2))
    assert second.predicted[0].sigma_position < second.predicted[1].sigma_position

    blind = lister.obstacles(now)
    assert [o.cpa for o in blind] == [None, None]  # without a pose there is no course
    lister.end(now.take(np.array([0])))
    gone: Obstacle = lister.obstacles(now.take(np.array([1])), AT_REST)[-1]
    assert (gone.state, gone.cpa, gone.predicted) == ("terminated", None, [])


def test_an_uncertain_shape_makes_the_approach_uncertain() -> None:
    lister = ObstacleLister(PlannerSettings(shape_sigma=0.5, lead_times_s=()), STILL, BottomSettings())
    now = objects([[10.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]])
    now = replace(now, sigma_radius=np.zeros(1), sigma_velocity=np.zeros((3, 1)))
    (only,) = lister.obstacles(now, AT_REST)
    assert isinstance(only.cpa, ClosestApproach)
    assert only.cpa.sigma_m == pytest.approx(np.sqrt(0.3**2 + 0.5**2 + 0.5**2))
    assert only.predicted == []
