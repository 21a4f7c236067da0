"""Eq. 1 by hand-computed cases, the noise of a measurement against simulated noise, and what the sonar can see."""

import math

import msgspec
import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.frames.geometry import euler_from_quat, quat_from_euler
from ods.messages import Detection, Detections
from ods.tracker.measurement.coverage.field_of_view import coverage_of, field_of_view, near_coverage
from ods.tracker.measurement.from_detections import received
from ods.tracker.measurement.model import ATTITUDE, BEND, HEIGHT, position_measurement
from ods.tracker.measurement.scan import Echoes, Vehicle, echo_table_of, echoes_of, vehicle_at
from tests.tracker.samples import HALF_VERTICAL, NO_SIGMA, SECTOR, predicted_measurement


def vehicle(
    position: list[float], euler: list[float], sigma_position: Floats = NO_SIGMA, sigma_attitude: Floats = NO_SIGMA
) -> Vehicle:
    made = vehicle_at(np.array(position), quat_from_euler(*euler), sigma_position, sigma_attitude)
    assert made is not None
    return made


def one_echo(distance: float, bearing: float, elevation: float = 0.0, sigma_bearing: float = 1e-4) -> Echoes:
    return echoes_of(np.array([[distance, bearing, elevation, 1.0, 0.1, sigma_bearing, 0.3]]))[0]


RIGHT = math.radians(90.0)


@pytest.mark.parametrize(
    ("position", "euler", "distance", "bearing", "elevation", "expected"),
    [
        ([0, 0, 0], [0, 0, 0], 10.0, 0.0, 0.0, [10, 0, 0]),
        ([0, 0, 0], [0, 0, 0], 10.0, RIGHT, 0.0, [0, 10, 0]),  # starboard is east when we look north
        ([5, 6, 7], [0, 0, RIGHT], 10.0, 0.0, 0.0, [5, 16, 7]),  # looking east
        ([5, 6, 7], [0, 0, RIGHT], 10.0, RIGHT, 0.0, [-5, 6, 7]),
        (
            [0, 0, 0],
            [0, math.radians(30.0), 0],
            10.0,
            0.0,
            0.0,
            [8.660254, 0, -5],
        ),  # bow up: the fan's middle is higher
        ([0, 0, 0], [math.radians(30.0), 0, 0], 10.0, RIGHT, 0.0, [0, 8.660254, 5]),  # starboard side down
        ([0, 0, 0], [0, 0, 0], 10.0, 0.0, math.radians(30.0), [8.660254, 0, -5]),  # a plane that looks up
    ],
)
def test_eq_1(
    position: list[float], euler: list[float], distance: float, bearing: float, elevation: float, expected: list[float]
) -> None:
    place = position_measurement(
        one_echo(distance, bearing, elevation), vehicle(position, euler), HALF_VERTICAL
    ).position[:, 0]
    np.testing.assert_allclose(place, expected, atol=1e-6)


def test_the_fan_tells_an_interval_of_height() -> None:
    measured = position_measurement(one_echo(50.0, 0.3), vehicle([0, 0, 4], [0, 0, 0]), HALF_VERTICAL)
    np.testing.assert_allclose(measured.position[2], 4.0)
    np.testing.assert_allclose(measured.half_height, 50.0 * math.sin(math.radians(10.0)))


def test_the_place_at_every_height_of_the_fan() -> None:
    """Points on the arc of one range and bearing, by rotations of their own, against the parabola in the height."""
    distance, bearing = 50.0, math.radians(25.0)
    for roll, pitch in ((0.0, 0.0), (0.0, 0.17), (0.1, -0.35), (-0.2, 0.3)):
        where = vehicle([3.0, -2.0, 4.0], [roll, pitch, 0.6])
        reported = position_measurement(one_echo(distance, bearing), where, HALF_VERTICAL)
        for elevation in np.linspace(-HALF_VERTICAL, HALF_VERTICAL, 9):
            place = arc_at(where, distance, bearing, elevation)
            lower = place[2] - reported.height[0]
            found = reported.position[:2, 0] + reported.sensitivity[HEIGHT, :, 0] * lower
            found = found + reported.sensitivity[BEND, :, 0] * lower**2
            np.testing.assert_allclose(found, place[:2], atol=0.002 * distance)
        # The tangent and its bend are those of the arc, by differences of points close together.
        arc = [arc_at(where, distance, bearing, e) for e in (-1e-3, 0.0, 1e-3)]
        slopes = [(arc[i + 1][:2] - arc[i][:2]) / (arc[i + 1][2] - arc[i][2]) for i in range(2)]
        np.testing.assert_allclose(0.5 * (slopes[0] + slopes[1]), reported.sensitivity[HEIGHT, :, 0], atol=1e-5)
        bend = (slopes[1] - slopes[0]) / (arc[2][2] - arc[0][2])
        np.testing.assert_allclose(bend, reported.sensitivity[BEND, :, 0], atol=1e-5)


def arc_at(where: Vehicle, distance: float, bearing: float, elevation: float) -> Floats:
    level = math.cos(elevation)
    body = distance * np.array([level * math.cos(bearing), level * math.sin(bearing), -math.sin(elevation)])
    place: Floats = where.position + where.rotation @ body
    return place


def test_an_echo_is_taken_in_where_its_object_should_be() -> None:
    """An object expected 3 m farther left: along the tangent there, with the ellipse of there, not of the echo."""
    where, place = vehicle([0, 0, 0], [0, 0, 0]), np.array([[50.0], [-3.0], [0.0]])
    expected = predicted_measurement(place, 1e-6 * np.ones((3, 1)), np.zeros(1), where)
    reported = position_measurement(one_echo(50.5, 0.0, sigma_bearing=0.03), where, HALF_VERTICAL, expected.table)
    distance, bearing = math.hypot(50.0, 3.0), math.atan2(-3.0, 50.0)
    ahead = np.array([math.cos(bearing), math.sin(bearing)])
    aside = np.array([-math.sin(bearing), math.cos(bearing)])
    np.testing.assert_allclose(reported.position[:2, 0], 50.5 * ahead - distance * bearing * aside, atol=1e-3)
    noise = np.outer(ahead, ahead) * 0.1**2 + np.outer(aside, aside) * (distance * 0.03) ** 2
    told_noise = [reported.variance_north[0], reported.variance_east[0], reported.covariance_ne[0]]
    np.testing.assert_allclose(told_noise, [noise[0, 0], noise[1, 1], noise[0, 1]], rtol=1e-3)


def test_a_wide_beam_does_not_make_ranges_too_long() -> None:
    """The middle of 400,000 places seen with 3 deg of noise, and the range expected of that middle."""
    rng, distance, sigma = np.random.default_rng(4), 100.0, math.radians(3.0)
    where = vehicle([0, 0, 0], [0, 0, 0])
    reported = position_measurement(one_echo(distance, 0.0, sigma_bearing=sigma), where, HALF_VERTICAL)
    azimuth = sigma * rng.standard_normal(400_000)
    np.testing.assert_allclose(reported.position[0, 0], np.mean(distance * np.cos(azimuth)), atol=1e-3)
    variance = np.array([[reported.variance_north[0]], [reported.variance_east[0]], [0.0]])
    np.testing.assert_allclose(variance[0, 0], 0.1**2 + np.var(distance * np.cos(azimuth)), rtol=0.02)
    np.testing.assert_allclose(variance[1, 0], np.var(distance * np.sin(azimuth)), rtol=0.02)
    again = predicted_measurement(reported.position, variance, reported.covariance_ne, where)
    np.testing.assert_allclose(again.rows.range_m[0], distance, atol=2e-3)


def test_what_was_seen_alike_is_expected_alike_whatever_the_height() -> None:
    """The range of an object on the arc is known, however uncertain its place is; from elsewhere it is not."""
    here, there = vehicle([0, 0, 0], [0, 0.3, 0]), vehicle([0, 0, 0], [0, 0.0, 0])
    reported = position_measurement(one_echo(50.0, 0.3), here, HALF_VERTICAL)
    place = np.vstack([reported.position[:2], reported.height])
    variance = np.array([[1e-6], [1e-6], [25.0]])
    again = predicted_measurement(place, variance, np.zeros(1), here, reported.sensitivity[HEIGHT])
    np.testing.assert_allclose([again.rows.along[0], again.rows.across[0]], 0.0, atol=1e-4)
    level = predicted_measurement(place, variance, np.zeros(1), there, reported.sensitivity[HEIGHT])
    np.testing.assert_allclose(level.rows.along[0], again.rows.along[0], atol=1e-4)  # range is range, however it turns
    moved = predicted_measurement(
        place, variance, np.zeros(1), vehicle([25.0, 0, 0], [0, 0.3, 0]), reported.sensitivity[0]
    )
    assert math.sqrt(moved.rows.along[0]) > 0.5


def test_a_tilt_turns_aside_what_lies_lower() -> None:
    """By how much the place of an echo from below is another one, for a vehicle tilted about its line of sight."""
    tilt, nowhere_else = 1e-3, 1e-6
    reported = vehicle([0, 0, 0], [0, -0.4, 0], sigma_attitude=np.array([tilt, tilt, 0.0]))
    about_north = np.array(
        [[1.0, 0.0, 0.0], [0.0, math.cos(tilt), -math.sin(tilt)], [0.0, math.sin(tilt), math.cos(tilt)]]
    )
    tilted = reported._replace(rotation=about_north @ reported.rotation)
    here, there = (position_measurement(one_echo(50.0, 0.0), each, nowhere_else) for each in (reported, tilted))
    moved = there.position[:2, 0] - here.position[:2, 0]
    assert abs(moved[1]) == pytest.approx(50.0 * math.sin(0.4) * tilt, rel=1e-3)
    np.testing.assert_allclose(np.abs(here.sensitivity[ATTITUDE, :, 0]), np.abs(moved), rtol=1e-3, atol=1e-6)


def test_line_of_sight_turns_as_the_place_moves() -> None:
    """Its azimuth by small differences, before a vehicle that pitches and rolls."""
    where, small = vehicle([5.0, 6.0, 7.0], [0.2, -0.3, 0.5]), 1e-6
    reported = position_measurement(one_echo(40.0, 0.4), where, HALF_VERTICAL)
    north, east = reported.position[:2, 0] - where.position[:2]
    azimuth = math.atan2(east, north)
    by_north, by_east = math.atan2(east, north + small) - azimuth, math.atan2(east + small, north) - azimuth
    np.testing.assert_allclose(reported.azimuth[:, 0], np.array([by_north, by_east]) / small, rtol=1e-3)


def test_a_sensor_that_knows_nothing_breaks_nothing() -> None:
    """Absurd claims and lines of sight straight down give finite places with positive definite noise."""
    rng = np.random.default_rng(6)
    for _ in range(300):
        claims = 10.0 ** rng.uniform(-4.0, 4.0, 3)
        row = [10.0 ** rng.uniform(-1.0, 4.0), rng.uniform(-3, 3), rng.uniform(-1.5, 1.5), 1.0, *claims]
        where = vehicle(rng.uniform(-100, 100, 3).tolist(), rng.uniform(-1.5, 1.5, 3).tolist(), 0.3 * np.ones(3))
        reported = position_measurement(echoes_of(np.array([row]))[0], where, HALF_VERTICAL)
        for name, field in reported._asdict().items():
            assert np.isfinite(field).all(), name
        nn, ee, ne = reported.variance_north[0], reported.variance_east[0], reported.covariance_ne[0]
        assert nn > 0.0
        assert ee > 0.0
        assert abs(ne) < math.sqrt(nn * ee)


def test_the_noise_is_that_of_range_bearing_and_pose() -> None:
    """Sample covariance of 200,000 noisy measurements of one object through noisy poses."""
    rng = np.random.default_rng(2)
    count, distance, bearing, yaw = 200_000, 60.0, math.radians(25.0), math.radians(40.0)
    sigma_position, sigma_yaw = np.array([0.3, 0.2, 0.0]), math.radians(0.7)
    ranges = distance + rng.normal(0.0, 0.1, count)
    azimuth = yaw + rng.normal(0.0, sigma_yaw, count) + bearing + rng.normal(0.0, 0.01, count)
    north = rng.normal(0.0, 0.3, count) + ranges * np.cos(azimuth)
    east = rng.normal(0.0, 0.2, count) + ranges * np.sin(azimuth)
    sample = np.cov(north, east)
    noisy = vehicle([0, 0, 0], [0, 0, yaw], sigma_position, np.array([0.0, 0.0, sigma_yaw]))
    noisy = noisy._replace(noise=sigma_position)
    measured = position_measurement(one_echo(distance, bearing, sigma_bearing=0.01), noisy, HALF_VERTICAL)
    reported = [measured.variance_north[0], measured.covariance_ne[0], measured.variance_east[0]]
    np.testing.assert_allclose(reported, sample[[0, 0, 1], [0, 1, 1]], rtol=0.02)


def test_prediction_is_the_inverse_of_eq_1() -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        where = vehicle(rng.uniform(-100, 100, 3).tolist(), rng.uniform(-0.4, 0.4, 3).tolist())
        distance, bearing = float(rng.uniform(1, 100)), float(rng.uniform(-1, 1))
        place = position_measurement(one_echo(distance, bearing), where, HALF_VERTICAL).position
        seen = predicted_measurement(place, 1e-9 * np.ones((3, 1)), np.zeros(1), where)
        np.testing.assert_allclose(
            [seen.rows.range_m[0], seen.rows.bearing[0], seen.rows.elevation[0]], [distance, bearing, 0.0], atol=1e-6
        )


def test_the_predicted_covariance_is_turned_to_the_line_of_sight() -> None:
    """Looking north-east at a covariance that is long in that direction: all of it is along, none across."""
    place = np.array([[10.0], [10.0], [0.0]])
    seen = predicted_measurement(place, np.array([[2.0], [2.0], [0.0]]), np.array([1.9]), vehicle([0, 0, 0], [0, 0, 0]))
    np.testing.assert_allclose(
        [seen.rows.along[0], seen.rows.across[0], seen.rows.mixed[0]], [3.9, 0.1, 0.0], atol=1e-12
    )


def test_an_object_at_the_vehicles_own_place_is_no_trouble() -> None:
    seen = predicted_measurement(np.zeros((3, 1)), np.ones((3, 1)), np.zeros(1), vehicle([0, 0, 0], [0, 0, 0]))
    for name, field in seen.rows._asdict().items():
        assert np.isfinite(field).all(), name


def seen_at(place: list[float], sigma: float, sigma_down: float = 0.01) -> tuple[bool, float]:
    variance = np.array([[sigma**2], [sigma**2], [sigma_down**2]])
    predicted = predicted_measurement(
        np.array([place], float).T.copy(), variance, np.zeros(1), vehicle([0, 0, 0], [0, 0, 0])
    )
    result = field_of_view(predicted, np.zeros(predicted.table.shape[-1]), coverage_of(SECTOR), (), 2.0)
    return bool(result.inside[0]), float(result.watched[0])


def test_what_is_in_view() -> None:
    assert seen_at([50, 0, 0], 0.1) == (True, 1.0)
    assert seen_at([-50, 0, 0], 0.1) == (False, 0.0)
    assert seen_at([101, 0, 0], 0.1) == (False, 0.0)
    assert seen_at([99.9, 0, 0], 0.1) == (True, 0.0)  # at the edge: neither outside nor expected
    assert seen_at([50, 49, 0], 1.0) == (True, 0.0)
    assert seen_at([50, 51, 0], 1.0) == (False, 0.0)
    assert seen_at([50, 0, 20], 0.1) == (False, 0.0)  # below the fan


def test_a_height_half_known_is_half_watched() -> None:
    """The fan covers +-8.7 m at 50 m; a height anywhere in 0 to 17.4 m is seen in half of the cases."""
    half = 50.0 * math.sin(HALF_VERTICAL) / math.hypot(1.0, 0.0)
    _, watched = seen_at([50.0, 0.0, half], 0.1, half / math.sqrt(3.0))
    assert watched == pytest.approx(0.5, abs=0.02)


def test_near_the_sector() -> None:
    predicted = predicted_measurement(
        np.array([[50.0, 50.0, 50.0], [53.0, 60.0, -80.0], [0.0, 0.0, 0.0]]),
        np.ones((3, 3)),
        np.zeros(3),
        vehicle([0, 0, 0], [0, 0, 0]),
    )
    assert near_coverage(predicted, coverage_of(SECTOR), 10.0).tolist() == [True, True, False]


def test_bad_echoes_and_poses_are_left_out() -> None:
    good = [50.0, 0.1, 0.0, 1.0, 0.1, 0.01, 0.3]
    table = np.array([good] * 6)
    table[1, 0] = np.nan
    table[2, 0] = -1.0
    table[3, 1] = np.inf
    table[4, 3] = -0.1
    table[5, 4] = 1e300
    kept, dropped = echoes_of(table)
    assert (len(kept), dropped) == (1, 5)
    assert len(echoes_of(echo_table_of([]))[0]) == 0
    assert vehicle_at(np.array([0.0, np.nan, 0.0]), quat_from_euler(0, 0, 0), NO_SIGMA, NO_SIGMA) is None
    assert euler_from_quat(quat_from_euler(0, 0, 1.0))[2] == pytest.approx(1.0)


def test_a_scan_is_the_same_however_its_echoes_are_parted_in_faint_ones_and_others() -> None:
    echoes = [
        Detection(40.0 + k, bearing, 1.0, 9.0, 5.0, 12.0, 8, 0.5, 0.1, 0.1, 0.01, 0.3)
        for k, bearing in enumerate((-0.5, -0.2, 0.1, 0.1, 0.4))
    ]
    message = Detections(0, 0, 0, 0, 0, 1500.0, SECTOR, echoes)
    faint = msgspec.structs.replace(message, detections=echoes[1:4:2], faint=[echoes[0], echoes[2], echoes[4]])
    all_of_it, parted = (received(each, None, lambda _: None, 0).scan.echoes for each in (message, faint))
    assert len(parted) == 5
    np.testing.assert_array_equal(np.sort(parted.rows.range_m), all_of_it.rows.range_m)
    np.testing.assert_array_equal(parted.rows.bearing, all_of_it.rows.bearing)
