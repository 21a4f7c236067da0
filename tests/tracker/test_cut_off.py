"""Bodies that the fan's edge cuts off: what is seen of them slides along them, which is not taken for their motion.

The echoes are made here from circles and the fan's borders.
"""

import math

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.geometry import quat_from_euler
from ods.tracker.measurement.coverage.cut_off import limit_information
from ods.tracker.measurement.coverage.field_of_view import coverage_of, field_of_view
from ods.tracker.measurement.model import PredictedMeasurement
from ods.tracker.measurement.scan import Echoes, Scan, echoes_of, vehicle_at
from ods.tracker.named import Named
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import HALF_FOV, NO_SIGMA, RATE_HZ, SECTOR, SIGMA_BEARING, SIGMA_RADIUS, SIGMA_RANGE

HIDDEN_M = 5.0
FAR_M = 40.0


def echo_of(place: Floats, radius: float, rng: np.random.Generator) -> tuple[float, ...] | None:
    """Return the row of what is seen of a circle by a sonar in the origin that looks north; None: it is out of view."""
    distance, middle = math.hypot(*place), math.atan2(place[1], place[0])
    half = math.asin(radius / distance)
    low, high = max(middle - half, -HALF_FOV), min(middle + half, HALF_FOV)
    if high - low < math.radians(1.0):
        return None
    aside = max(abs(middle) - HALF_FOV, 0.0)
    near = distance * math.cos(aside) - math.sqrt(radius**2 - (distance * math.sin(aside)) ** 2)
    cut = high - low < 1.999 * half
    seen = distance * math.sin(0.5 * (high - low))
    noise = rng.standard_normal(2) * (SIGMA_RANGE, SIGMA_BEARING)
    sigmas = SIGMA_RANGE, SIGMA_BEARING, SIGMA_RADIUS
    if cut:
        sigmas = math.hypot(SIGMA_RANGE, seen), HIDDEN_M / distance, HIDDEN_M
    return (near + seen + noise[0], 0.5 * (low + high) + noise[1], 0.0, seen, *sigmas, 20.0, float(cut))


def crossing(radius: float, speed: float, side: float, seed: int) -> list[tuple[Floats, float, Snapshot]]:
    """Return places of a body that moves along a circle's tangent over the border, how far it is out, and the lists."""
    rng, tracker = np.random.default_rng(seed), Tracker(TrackerSettings())
    border = side * HALF_FOV
    outwards = side * np.array([-math.sin(border), math.cos(border)])
    start = FAR_M * np.array([math.cos(border), math.sin(border)]) - (2.0 * radius + 10.0) * outwards
    vehicle = vehicle_at(np.zeros(3), quat_from_euler(0.0, 0.0, 0.0), NO_SIGMA, NO_SIGMA)
    found = []
    for k in range(round((3.5 * radius + 10.0) / speed * RATE_HZ)):
        place, t_ns = start + speed * k / RATE_HZ * outwards, round(k / RATE_HZ * NS)
        row = echo_of(place, radius, rng)
        echoes = echoes_of(np.array([row] if row else []).reshape(-1, 9))[0]
        tracker.step(Scan(t_ns, t_ns, vehicle, SECTOR, echoes))
        found.append((place, float((place - start) @ outwards) - 2.0 * radius - 10.0, tracker.snapshot()))
    return found


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize(("radius", "speed"), [(0.5, 0.5), (1.5, 0.7), (3.0, 1.5), (3.0, 0.7)])
def test_a_body_that_leaves_keeps_place_speed_and_size(radius: float, speed: float, side: float) -> None:
    nees = []
    for place, beyond, tracks in crossing(radius, speed, side, seed=3):
        if not -radius < beyond < 1.4 * radius:
            continue
        assert len(tracks) == 1
        error = tracks.position[:2, 0] - place
        covariance = np.diag(tracks.sigma_position[:2, 0] ** 2)
        covariance[0, 1] = covariance[1, 0] = tracks.covariance_ne[0]
        nees.append(float(error @ np.linalg.solve(covariance, error)))
        assert tracks.radius[0] > 0.9 * radius
        outwards = side * np.array([-math.sin(side * HALF_FOV), math.cos(HALF_FOV)])
        assert tracks.velocity[:2, 0] == pytest.approx(speed * outwards, abs=0.12)
    assert np.mean(nees) < 2.5


def predictions(along: float, across: float) -> Named[PredictedMeasurement]:
    one = np.ones(1)
    fields = 40.0 * one, 0.7 * one, 0.0 * one, 40.0 * one, along * one, across * one, 0.0 * one, one
    return Named(PredictedMeasurement, np.stack(fields))


def cut_echo(radius: float) -> Echoes:
    return echoes_of(np.array([[39.0, 0.7, 0.0, radius, 1.0, HIDDEN_M / 40.0, HIDDEN_M, 20.0, 1.0]]))[0]


def test_a_hundred_cut_echoes_tell_as_much_as_one() -> None:
    along, across, size = 30.0, 60.0, 9.0
    for _ in range(100):
        rows = limit_information(
            cut_echo(1.0), predictions(along, across).table, np.full(1, 4.0), np.full(1, size)
        ).rows
        along, across, size = (
            known * noise / (known + noise)
            for known, noise in (
                (along, rows.sigma_range[0] ** 2),
                (across, (40.0 * rows.sigma_bearing[0]) ** 2),
                (size, rows.sigma_radius[0] ** 2),
            )
        )
    assert along == pytest.approx(1.0, rel=1e-3)
    assert across == pytest.approx(min(HIDDEN_M**2, 4.0**2 + 9.0), rel=1e-3)
    assert size == pytest.approx(9.0, rel=1e-3)


def test_a_part_larger_than_the_body_was_thought_to_be_is_believed_and_whole_echoes_stay_as_they_are() -> None:
    known, before, variance = predictions(0.1, 0.1).table, 1.0, 4.0
    rows = limit_information(cut_echo(2.0), known, np.full(1, before), np.full(1, variance)).rows
    gain = variance / (variance + rows.sigma_radius[0] ** 2)
    after = before + gain * (rows.radius[0] - before)
    assert after == pytest.approx(before + variance / (variance + HIDDEN_M**2), rel=1e-3)  # as by the echo alone
    assert (1.0 - gain) * variance == pytest.approx(variance, rel=1e-3)
    whole = echoes_of(np.array([[39.0, 0.7, 0.0, 0.5, 1.0, 0.1, 0.3, 20.0, 0.0]]))[0]
    np.testing.assert_array_equal(limit_information(whole, known, np.ones(1), np.ones(1)).table, whole.table)


@pytest.mark.parametrize("aside_m", [8.0, 11.0])
@pytest.mark.parametrize("image", [0, 1])
def test_a_false_alarm_beside_a_body_does_not_live_by_the_part_seen_of_it(aside_m: float, image: int) -> None:
    """It took all echoes of the body, which said nothing of its place until that was vague: a leap, 1.3 to 1.8 m/s."""
    vehicle = vehicle_at(np.zeros(3), quat_from_euler(0.0, 0.0, 0.0), NO_SIGMA, NO_SIGMA)
    tracker, bearing = Tracker(TrackerSettings()), HALF_FOV - 0.04
    part = FAR_M, bearing, 0.0, 2.0, 2.0, HIDDEN_M / FAR_M, HIDDEN_M, 25.0, 1.0
    alarm = FAR_M, bearing - aside_m / FAR_M, 0.0, 0.3, 0.3, 0.3 / FAR_M, 2.0, 10.0, 0.0
    for k in range(round(8.0 * RATE_HZ)):
        t_ns, rows = round(k / RATE_HZ * NS), np.array([part, alarm] if k == image else [part])
        tracker.step(Scan(t_ns, t_ns, vehicle, SECTOR, echoes_of(rows)[0]))
    tracks = tracker.snapshot()
    assert len(tracks) == 1
    seen = FAR_M * np.array([math.cos(bearing), math.sin(bearing)])
    assert math.hypot(*(tracks.position[:2, 0] - seen)) < 0.5
    assert math.hypot(*tracks.velocity[:2, 0]) < 0.05


def test_bodies_whose_echo_is_one_and_cut_off_are_no_larger_than_it() -> None:
    """Two close bodies at the fan's edge: one grew to a hundred times what the echo was larger than it."""
    vehicle = vehicle_at(np.zeros(3), quat_from_euler(0.0, 0.0, 0.0), NO_SIGMA, NO_SIGMA)
    tracker, largest = Tracker(TrackerSettings()), 0.0
    apart = [(FAR_M, HALF_FOV - aside, 0.0, 1.0, 1.0, 0.01, HIDDEN_M, 25.0, 1.0) for aside in (0.07, 0.03)]
    joined = FAR_M, HALF_FOV - 0.04, 0.0, 2.5, 2.5, HIDDEN_M / FAR_M, HIDDEN_M, 25.0, 1.0
    for k in range(round(6.0 * RATE_HZ)):
        t_ns, rows = round(k / RATE_HZ * NS), np.array(apart if k < 3.0 * RATE_HZ else [joined])
        tracker.step(Scan(t_ns, t_ns, vehicle, SECTOR, echoes_of(rows)[0]))
        largest = max(largest, *tracker.snapshot().radius, 0.0)
    assert 1.0 <= largest < 2.5


@pytest.mark.parametrize("beyond_m", [-3.0, -1.0, 0.0, 1.0, 3.0])
def test_a_body_is_expected_while_a_part_of_it_is_inside(beyond_m: float) -> None:
    """By the share of a normal distribution of parts, half the radius wide, drawn at random."""
    one, sigma, radius = np.ones(1), 0.3, 3.0
    bearing = HALF_FOV + beyond_m / 40.0
    fields = 40.0 * one, bearing * one, 0.0 * one, 40.0 * one, 0.01 * one, sigma**2 * one, 0.0 * one, 1e-4 * one
    told = field_of_view(Named(PredictedMeasurement, np.stack(fields)), radius * one, coverage_of(SECTOR), (), 2.0)
    rng = np.random.default_rng(1)
    parts = beyond_m + sigma * rng.standard_normal(200_000) + 0.5 * radius * rng.standard_normal(200_000)
    assert told.probability[0] == pytest.approx((parts < 0.0).mean(), abs=0.005)
    assert told.inside[0] == (beyond_m <= 0.0)
