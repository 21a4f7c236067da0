"""Velocities and predictions are as sure as they are told to be, for each kind of motion by itself.

The echoes are made here, of objects before a vehicle that hovers, on courses in closed form.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.messages import Sector
from ods.tracker.measurement.scan import Scan, Vehicle, echoes_of
from ods.tracker.observer.registry import CHANGE_RATE
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import MotionSettings, TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.test_approach import objects

RATE_HZ = 5.0
COUNT = 6
SECTOR = Sector(0.0, 120.0, -math.radians(45.0), math.radians(45.0), math.radians(10.0))
SIGMA_RANGE, SIGMA_BEARING = 0.1, math.radians(0.5)
LEAD_S = 10.0

Course = Callable[[float], tuple[Floats, Floats]]
"""Displacement and velocity (2,) at a time since the start, s, of an object that first goes north."""


def straight(speed: float) -> Course:
    """Return a course at constant speed."""
    return lambda t: (np.array([speed * t, 0.0]), np.array([speed, 0.0]))


def setting_out(acceleration: float) -> Course:
    """Return a course of one that rests and then grows faster and faster."""
    return lambda t: (np.array([0.5 * acceleration * t**2, 0.0]), np.array([acceleration * t, 0.0]))


def turning(speed: float, rate: float) -> Course:
    """Return a circle, `rate` in rad/s."""

    def at(t: float) -> tuple[Floats, Floats]:
        c, s = math.cos(rate * t), math.sin(rate * t)
        return speed / rate * np.array([s, 1.0 - c]), speed * np.array([c, s])

    return at


def normalised(course: Course, seconds: float, run: int, observer: str) -> tuple[Floats, Floats]:
    """Return (COUNT,) squared errors over variances told, north and east, of velocity and of the place in LEAD_S."""
    rng, tracker = np.random.default_rng([17, run]), Tracker(TrackerSettings(observer=observer))
    bearing = np.radians(np.linspace(-35.0, 35.0, COUNT))
    start = rng.uniform(30.0, 70.0, COUNT) * np.array([np.cos(bearing), np.sin(bearing)])
    way = rng.uniform(-math.pi, math.pi, COUNT)
    turn = np.array([[np.cos(way), -np.sin(way)], [np.sin(way), np.cos(way)]])
    vehicle = Vehicle(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
    for k in range(round(seconds * RATE_HZ) + 1):
        north, east = start + np.einsum("ijn,j->in", turn, course(k / RATE_HZ)[0])
        rows = np.zeros((COUNT, 7))
        rows[:, 0] = np.hypot(north, east) + SIGMA_RANGE * rng.standard_normal(COUNT)
        rows[:, 1] = np.arctan2(east, north) + SIGMA_BEARING * rng.standard_normal(COUNT)
        rows[:, 3:] = 1.0, SIGMA_RANGE, SIGMA_BEARING, 0.3
        received = rows[rng.random(COUNT) < 0.9]
        t_ns = round(k / RATE_HZ * NS)
        tracker.step(Scan(t_ns, t_ns, vehicle, SECTOR, echoes_of(received)[0]))
    now = nearest(tracker.snapshot(), np.array([north, east]))
    later = now.extrapolated(LEAD_S, TrackerSettings().motion)
    velocity = np.einsum("ijn,j->in", turn, course(seconds)[1])
    place = start + np.einsum("ijn,j->in", turn, course(seconds + LEAD_S)[0])
    off, off_later = now.velocity[:2] - velocity, later.position[:2] - place
    return ((off / now.sigma_velocity[:2]) ** 2).sum(axis=0), ((off_later / later.sigma_position[:2]) ** 2).sum(axis=0)


def nearest(picture: Snapshot, places: Floats) -> Snapshot:
    """Return the object told nearest to each place, (2, COUNT)."""
    apart = np.hypot(*(picture.position[:2, :, None] - places[:, None, :]))
    assert (apart.min(axis=0) < 5.0).all()
    return picture.take(apart.argmin(axis=0))


def means(course: Course, seconds: float, observer: str = "manoeuvring") -> tuple[float, float]:
    """Return the mean of both of `normalised` over 36 objects."""
    found = np.array([normalised(course, seconds, run, observer) for run in range(6)])
    velocity, place = found.mean(axis=(0, 2))
    return float(velocity), float(place)


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.3])
def test_a_velocity_not_told_from_rest_yet_is_told_as_uncertain(speed: float) -> None:
    """Before, the mean of the velocity's, 2 when errors are as large as told, was 72, 69 and 3.1."""
    velocity, place = means(straight(speed), 3.0)
    assert velocity < 2.5
    assert place < 2.5


@pytest.mark.parametrize("speed", [0.05, 0.1])
@pytest.mark.parametrize("observer", ["independent", "coupled"])
def test_so_it_is_by_observers_of_one_kind_of_motion(observer: str, speed: float) -> None:
    """Before, the means of the velocity's were 37 to 43, of the place's 2.6 to 5.1."""
    velocity, place = means(straight(speed), 3.0, observer)
    assert velocity < 4.0
    assert place < 2.0


def test_one_that_sets_out_is_not_told_to_rest_for_sure() -> None:
    """Before, the means were 129 and 92. They are above 2 still: no constant velocity is what it has."""
    velocity, place = means(setting_out(0.1), 3.0)
    assert velocity < 6.0
    assert place < 25.0


def test_what_rests_is_told_surely_all_the_same() -> None:
    """What creeps unseen must not stay in what is told of objects at rest."""
    tracker = Tracker(TrackerSettings())
    rng, vehicle = np.random.default_rng(5), Vehicle(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
    for k in range(round(20.0 * RATE_HZ)):
        noise = SIGMA_RANGE * rng.standard_normal(), SIGMA_BEARING * rng.standard_normal()
        row = [50.0 + noise[0], noise[1], 0.0, 1.0, SIGMA_RANGE, SIGMA_BEARING, 0.3]
        t_ns = round(k / RATE_HZ * NS)
        tracker.step(Scan(t_ns, t_ns, vehicle, SECTOR, echoes_of(np.array([row]))[0]))
    picture = tracker.snapshot()
    # A straight line through so many places, 0.44 m off across, has a slope known to 0.0076 m/s (least squares).
    assert (picture.sigma_velocity[:2, 0] < 0.025).all()


def test_what_turns_is_predicted_as_uncertain_as_it_goes_on_turning() -> None:
    """Before, the means were 3.6 and 8.4 (turns of 5 and 10 deg/s, after 9 s)."""
    for rate_deg in (5.0, 10.0):
        _, place = means(turning(1.0, math.radians(rate_deg)), 9.0)
        assert place < 3.3, rate_deg


@pytest.mark.parametrize("dt", [0.0, 0.3, 5.0, 20.0, 300.0])
def test_what_a_manoeuvre_adds_is_its_integral(dt: float) -> None:
    """Accelerations of now, which are left off at CHANGE_RATE, and those that are usual, by numerical integration."""
    motion, restless = MotionSettings(), 0.08
    now = replace(objects([[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0]]), restless=np.array([restless]))
    before = replace(now, restless=np.zeros(1))
    added = now.extrapolated(dt, motion).sigma_position ** 2 - before.extrapolated(dt, motion).sigma_position ** 2
    wanted, _ = quad(lambda u: restless * (dt - u) ** 2 * math.exp(-CHANGE_RATE * u), 0.0, dt)
    np.testing.assert_allclose(added, wanted, rtol=1e-6, atol=1e-9)
