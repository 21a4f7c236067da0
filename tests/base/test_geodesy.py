"""Positions on WGS 84: known points, PROJ's answers, round trips everywhere, poles and date line."""

import math

import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from numpy.typing import NDArray

from ods.base.frames.geometry import rotation_matrix
from ods.base.geodesy import SEMI_MAJOR_M, SEMI_MINOR_M, LocalFrame, ecef_of, geodetic_of

LATITUDES = st.floats(-90.0, 90.0)
LONGITUDES = st.floats(-180.0, 180.0, exclude_max=True)


@pytest.mark.parametrize(
    ("place", "ecef"),
    [
        ((0.0, 0.0, 0.0), (SEMI_MAJOR_M, 0.0, 0.0)),
        ((0.0, 90.0, 5.0), (0.0, SEMI_MAJOR_M + 5.0, 0.0)),
        ((90.0, 0.0, -7.0), (0.0, 0.0, SEMI_MINOR_M - 7.0)),
        # PROJ 9.5.1, EPSG:4979 to EPSG:4978
        ((57.048, 10.05, -35.0), (3424127.425021883, 606847.5443285356, 5328780.108359486)),
    ],
)
def test_known_points(place: tuple[float, float, float], ecef: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(ecef_of(*place), ecef, atol=2e-9)
    latitude, longitude, height = geodetic_of(ecef)
    np.testing.assert_allclose([latitude, longitude], place[:2], atol=1e-13)
    assert height == pytest.approx(place[2], abs=5e-9)


@pytest.mark.parametrize(
    ("origin", "ned", "place"),
    [  # PROJ 9.5.1: +proj=cart +step +proj=topocentric, inverse
        ((57.048, 10.05), (1234.5, -678.9, 20.0), (57.05908512010964, 10.03881099803017, -19.844527606852353)),
        ((-16.5, 179.999), (-250.0, 5000.0, 30.0), (-16.502253857806572, -179.95416704897934, -28.03577192593366)),
    ],
)
def test_local_frame_as_proj_has_it(
    origin: tuple[float, float], ned: tuple[float, float, float], place: tuple[float, float, float]
) -> None:
    frame = LocalFrame(*origin)
    latitude, longitude, height = frame.geodetic(ned)
    np.testing.assert_allclose([latitude, longitude], place[:2], atol=1e-13)
    assert height == pytest.approx(place[2], abs=5e-9)
    np.testing.assert_allclose(frame.ned(*place), ned, atol=5e-9)


@given(latitude=LATITUDES, longitude=LONGITUDES, height=st.floats(-11e3, 1e5))
@example(latitude=90.0, longitude=0.0, height=0.0)
@example(latitude=0.0, longitude=-180.0, height=-100.0)
@example(latitude=1e-300, longitude=0.0, height=0.0)
def test_there_and_back(latitude: float, longitude: float, height: float) -> None:
    """Compared in metres: at a pole every longitude is the same place."""
    place = ecef_of(latitude, longitude, height)
    back = geodetic_of(place)
    np.testing.assert_allclose(ecef_of(*back), place, atol=1e-8)
    assert back[0] == pytest.approx(latitude, abs=1e-12)
    assert back[2] == pytest.approx(height, abs=1e-8)
    assert -180.0 <= back[1] < 180.0


@given(
    latitude=LATITUDES,
    longitude=LONGITUDES,
    ned=st.lists(st.floats(-5e4, 5e4, allow_subnormal=False), min_size=3, max_size=3),
)
def test_local_there_and_back_and_true_to_length(latitude: float, longitude: float, ned: list[float]) -> None:
    frame = LocalFrame(latitude, longitude)
    place = frame.geodetic(ned)
    np.testing.assert_allclose(frame.ned(*place), ned, atol=2e-8)
    chord = ecef_of(*place) - ecef_of(latitude, longitude, 0.0)
    assert math.hypot(*chord) == pytest.approx(math.hypot(*ned), abs=2e-8)


def test_axes_point_where_they_say() -> None:
    frame = LocalFrame(57.0, 10.0)
    assert frame.geodetic([10.0, 0.0, 0.0])[0] > 57.0
    assert frame.geodetic([0.0, 10.0, 0.0])[1] > 10.0
    assert float(frame.geodetic([0.0, 0.0, 10.0])[2]) == pytest.approx(-10.0, abs=1e-8)
    assert np.linalg.det(frame.rotation()) == pytest.approx(1.0)


def test_many_at_once() -> None:
    frame = LocalFrame(-33.9, 151.2)
    ned = np.random.default_rng(0).uniform(-1e4, 1e4, (7, 3))
    together = np.array(frame.geodetic(ned)).T
    np.testing.assert_array_equal(together, [np.array(frame.geodetic(one)) for one in ned])


def geodesic(latitude: float, azimuth: float, length_m: float) -> tuple[float, float, float]:
    """Return latitude, difference in longitude and azimuth, rad, at the end of a geodesic: its equations, by steps."""
    state, steps = np.array([latitude, 0.0, azimuth]), 200

    def slope(at: NDArray[np.float64]) -> NDArray[np.float64]:
        phi, _, alpha = at
        e2 = 1.0 - (SEMI_MINOR_M / SEMI_MAJOR_M) ** 2
        across = SEMI_MAJOR_M / math.sqrt(1.0 - e2 * math.sin(phi) ** 2)
        along = across * (1.0 - e2) / (1.0 - e2 * math.sin(phi) ** 2)
        turn = math.sin(alpha) * math.tan(phi) / across
        return np.array([math.cos(alpha) / along, math.sin(alpha) / (across * math.cos(phi)), turn])

    for _ in range(steps):
        half = state + 0.5 * length_m / steps * slope(state)
        state = state + length_m / steps * slope(half)
    phi, away, alpha = state.tolist()
    return phi, away, alpha


@pytest.mark.parametrize("latitude_deg", [57.0, -33.0, 3.0])
@pytest.mark.parametrize("length_m", [1e4, 5e4])
def test_a_ship_that_goes_straight_on_turns_against_true_north_but_not_in_the_plane(
    latitude_deg: float, length_m: float
) -> None:
    phi, away, azimuth = geodesic(math.radians(latitude_deg), 0.5 * math.pi, length_m)
    frame = LocalFrame(latitude_deg, 10.0)
    turn = frame.turn(math.degrees(phi), 10.0 + math.degrees(away))
    north, east, _ = rotation_matrix(turn) @ [math.cos(azimuth), math.sin(azimuth), 0.0]
    assert math.atan2(north, east) == pytest.approx(0.0, abs=2e-9 * (length_m / 1e4) ** 3)
    convergence = azimuth - 0.5 * math.pi
    middle = 0.5 * (math.radians(latitude_deg) + phi)
    assert convergence == pytest.approx(away * math.sin(middle), rel=1e-4)
    if latitude_deg == 57.0:
        assert math.degrees(convergence) == pytest.approx({1e4: 0.14, 5e4: 0.7}[length_m], rel=0.05)


@given(
    latitude=st.floats(-89.0, 89.0),
    longitude=LONGITUDES,
    ned=st.tuples(st.floats(-1e5, 1e5), st.floats(-1e5, 1e5), st.floats(-100.0, 1e4)),
)
@example(latitude=0.0, longitude=180.0 - 3e-14, ned=(0.0, 0.0, 0.0))
def test_the_turn_of_a_place_by_steps_along_its_meridian_and_its_plumb_line(
    latitude: float, longitude: float, ned: tuple[float, float, float]
) -> None:
    frame = LocalFrame(latitude, longitude)
    here = [float(reported) for reported in frame.geodetic(ned)]
    if abs(here[0]) > 89.5:
        return

    def step(change: list[float]) -> NDArray[np.float64]:
        there, back = np.add(here, change), np.subtract(here, change)
        way = np.asarray(frame.ned(*there) - frame.ned(*back))
        return way / np.linalg.norm(way)

    north, down = step([1e-3, 0.0, 0.0]), step([0.0, 0.0, -100.0])
    axes = np.array([north, np.cross(down, north), down]).T
    np.testing.assert_allclose(rotation_matrix(frame.turn_at(ned)), axes, atol=1e-8)
    np.testing.assert_allclose(frame.turn(*here[:2]), frame.turn_at(ned), atol=1e-11)
