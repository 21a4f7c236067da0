"""The sonar head's pose against matrices of this file's own, and what the attitude's error does to its place."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.typing import NDArray

from ods.base.frames.mounting import AT_ORIGIN, Mounting, MountingSettings, lever_arm_in, mounting_in, spread_at
from ods.base.frames.quaternion import Quaternion, Vector3
from ods.base.settings_file import ConfigError, load
from ods.config import OnboardConfig

CONFIG = Path(__file__).parents[2] / "config" / "onboard.toml"
Matrix = NDArray[np.float64]
ANGLES = st.tuples(st.floats(-180.0, 180.0), st.floats(-90.0, 90.0), st.floats(-180.0, 180.0))
PLACES = st.tuples(*[st.floats(-20.0, 20.0)] * 3)


def turn(roll_deg: float, pitch_deg: float, yaw_deg: float) -> Matrix:
    """Return what turns a vector of the turned frame into the outer one: about z, then the new y, then the new x."""
    r, p, y = (math.radians(angle) for angle in (roll_deg, pitch_deg, yaw_deg))
    about_x = np.array([[1, 0, 0], [0, math.cos(r), -math.sin(r)], [0, math.sin(r), math.cos(r)]])
    about_y = np.array([[math.cos(p), 0, math.sin(p)], [0, 1, 0], [-math.sin(p), 0, math.cos(p)]])
    about_z = np.array([[math.cos(y), -math.sin(y), 0], [math.sin(y), math.cos(y), 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


def quaternion(matrix: Matrix) -> Quaternion:
    """Return the quaternion whose matrix it is: the eigenvector of Bar-Itzhack's 4 x 4 form."""
    m = matrix
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], m[1, 0] + m[0, 1], m[2, 0] + m[0, 2], m[2, 1] - m[1, 2]],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], m[2, 1] + m[1, 2], m[0, 2] - m[2, 0]],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], m[1, 0] - m[0, 1]],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], m[0, 0] + m[1, 1] + m[2, 2]],
        ]
    )
    x, y, z, w = np.linalg.eigh(k)[1][:, -1].tolist()
    return w, x, y, z


def axes(q: Quaternion) -> Matrix:
    """Return the matrix of a quaternion, by Rodrigues' formula."""
    vector = np.array(q[1:])
    cross = np.array([[0, -q[3], q[2]], [q[3], 0, -q[1]], [-q[2], q[1], 0]])
    return np.asarray(np.eye(3) + 2.0 * q[0] * cross + 2.0 * (np.outer(vector, vector) - vector @ vector * np.eye(3)))


def mounting(place: Vector3, angles_deg: Vector3) -> Mounting:
    roll, pitch, yaw = angles_deg
    return Mounting(MountingSettings(position_m=place, roll_deg=roll, pitch_deg=pitch, yaw_deg=yaw))


@given(place=PLACES, mounted=ANGLES, vehicle_ned=PLACES, attitude=ANGLES)
def test_any_head_on_any_vehicle(place: Vector3, mounted: Vector3, vehicle_ned: Vector3, attitude: Vector3) -> None:
    head, body = mounting(place, mounted), turn(*attitude)
    at, turned, lever = head.head(vehicle_ned, quaternion(body))
    np.testing.assert_allclose(lever, body @ place, atol=1e-12)
    np.testing.assert_allclose(at, vehicle_ned + body @ place, atol=1e-12)
    np.testing.assert_allclose(axes(turned), body @ turn(*mounted), atol=1e-12)
    many, turns = head.heads(np.array([vehicle_ned, vehicle_ned]), np.array([quaternion(body)] * 2))
    np.testing.assert_allclose(many, [at, at], atol=1e-12)
    np.testing.assert_allclose(turns, [turned, turned], atol=1e-12)


def test_signs_are_as_the_page_says() -> None:
    down = axes(mounting((0.0, 0.0, 0.0), (0.0, -15.0, 0.0)).turn) @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(down, [math.cos(math.radians(15.0)), 0.0, math.sin(math.radians(15.0))], atol=1e-12)
    starboard = axes(mounting((0.0, 0.0, 0.0), (0.0, 0.0, 90.0)).turn) @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(starboard, [0.0, 1.0, 0.0], atol=1e-12)
    upside_down = axes(mounting((0.0, 0.0, 0.0), (180.0, 0.0, 0.0)).turn) @ [0.0, 1.0, 0.0]
    np.testing.assert_allclose(upside_down, [0.0, -1.0, 0.0], atol=1e-12)


def test_a_vehicle_without_mounting_is_its_own_head_to_the_bit() -> None:
    rng = np.random.default_rng(1)
    places, attitudes = rng.normal(size=(50, 3)), rng.normal(size=(50, 4))
    attitudes /= np.linalg.norm(attitudes, axis=1)[:, None]
    for made, reported in zip(AT_ORIGIN.heads(places, attitudes), (places, attitudes), strict=True):
        np.testing.assert_array_equal(made, reported)


def test_spread_of_a_lever_s_end_by_drawn_errors() -> None:
    lever, sigma_attitude = (3.0, -1.0, 0.5), (0.02, 0.02, 0.05)
    rng = np.random.default_rng(2)
    tilt_north, tilt_east, yaw = rng.normal(size=(3, 100_000)) * np.array([[0.02], [0.02], [0.05]])
    swing = np.cross(np.array([tilt_north, tilt_east, yaw]).T, lever)
    drawn = rng.normal(size=(100_000, 3)) * (0.1, 0.2, 0.05) + swing
    np.testing.assert_allclose(spread_at(lever, (0.1, 0.2, 0.05), sigma_attitude), drawn.std(axis=0), rtol=0.01)


def test_the_configuration_tells_it_and_readers_of_nothing_else_find_it(tmp_path: Path) -> None:
    file = tmp_path / "onboard.toml"
    text = CONFIG.read_text(encoding="utf-8").replace(
        "[nav.canopen]", "[nav]\nlever_arm_m = [-1.5, 0.2, 0.0]\n[nav.canopen]"
    )
    text = text.replace("[sonar]", "[sonar]\nmounting = { position_m = [3.0, 0.0, 0.5], pitch_deg = -15 }")
    file.write_text(text, encoding="utf-8")
    reported = MountingSettings(position_m=(3.0, 0.0, 0.5), pitch_deg=-15.0)
    assert mounting_in(file) == reported
    assert lever_arm_in(file) == (-1.5, 0.2, 0.0)
    assert (mounting_in(CONFIG), lever_arm_in(CONFIG)) == (MountingSettings(), (0.0, 0.0, 0.0))
    (tmp_path / "tracker.toml").write_text("[tracker]\n", encoding="utf-8")
    assert mounting_in(tmp_path / "tracker.toml") == MountingSettings()
    for wrong in ("pitch_deg = -95", "yaw_deg = 181", "position_m = [101, 0, 0]", "position_m = [3, 0]", "tilt = 3"):
        file.write_text(text.replace("pitch_deg = -15", wrong).replace("position_m = [3.0, 0.0, 0.5], p", "p"), "utf-8")
        with pytest.raises(ConfigError, match=rf"sonar\.mounting\.{wrong.split()[0]}") as error:
            load(file, OnboardConfig)
        assert "\n" not in str(error.value)
