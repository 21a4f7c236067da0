import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.spatial.transform import Rotation, Slerp

from ods.base.frames import geometry, quaternion

angle = st.floats(-math.pi, math.pi)
pitch_angle = st.floats(-math.pi / 2 + 1e-3, math.pi / 2 - 1e-3)
coordinate = st.floats(-1e3, 1e3)
vector = st.tuples(coordinate, coordinate, coordinate)


def scipy_rotation(roll: float, pitch: float, yaw: float) -> Rotation:
    return Rotation.from_euler("ZYX", [yaw, pitch, roll])


@given(angle, angle, angle)
def test_quaternion_and_matrix_of_euler_angles_agree_with_scipy(roll: float, pitch: float, yaw: float) -> None:
    q = geometry.quat_from_euler(roll, pitch, yaw)
    expected = scipy_rotation(roll, pitch, yaw)
    assert abs(abs(q @ expected.as_quat(scalar_first=True)) - 1.0) < 1e-12
    np.testing.assert_allclose(geometry.rotation_matrix(q), expected.as_matrix(), atol=1e-12)


@given(angle, pitch_angle, angle)
def test_euler_angles_come_back(roll: float, pitch: float, yaw: float) -> None:
    back = geometry.euler_from_quat(geometry.quat_from_euler(roll, pitch, yaw))
    for found, wanted in zip(back, (roll, pitch, yaw), strict=True):
        assert abs(geometry.wrap_angle(float(found) - wanted)) < 1e-9


@given(angle, st.sampled_from([-math.pi / 2, math.pi / 2]), angle)
def test_looking_straight_up_or_down_keeps_the_attitude(roll: float, pitch: float, yaw: float) -> None:
    q = geometry.quat_from_euler(roll, pitch, yaw)
    again = geometry.quat_from_euler(*geometry.euler_from_quat(q))
    assert abs(abs(float(q @ again)) - 1.0) < 1e-9


@pytest.mark.parametrize(
    ("roll", "pitch", "yaw", "body", "ned"),
    [
        (0.0, 0.0, 90.0, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),  # heading east: forward is east
        (0.0, 0.0, 90.0, (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)),  # and starboard is south
        (0.0, 90.0, 0.0, (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)),  # nose up: forward is up
        (90.0, 0.0, 0.0, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),  # rolled to starboard: starboard is down
        (0.0, 30.0, 180.0, (2.0, 0.0, 0.0), (-math.sqrt(3.0), 0.0, -1.0)),
    ],
)
def test_attitudes_worked_out_by_hand(
    roll: float, pitch: float, yaw: float, body: tuple[float, ...], ned: tuple[float, ...]
) -> None:
    q = geometry.quat_from_euler(*np.radians([roll, pitch, yaw]))
    np.testing.assert_allclose(geometry.body_to_global(body, (0.0, 0.0, 0.0), q), ned, atol=1e-12)


def test_arrays_are_handled_row_by_row() -> None:
    rpy = np.random.default_rng(7).uniform(-1.5, 1.5, (5, 3))
    quats = geometry.quat_from_euler(rpy[:, 0], rpy[:, 1], rpy[:, 2])
    assert quats.shape == (5, 4)
    assert geometry.rotation_matrix(quats).shape == (5, 3, 3)
    np.testing.assert_allclose(np.stack(geometry.euler_from_quat(quats), -1), rpy, atol=1e-12)
    np.testing.assert_allclose(quats[3], geometry.quat_from_euler(*rpy[3]), atol=1e-15)


@given(vector, vector, angle, pitch_angle, angle)
def test_eq_1_and_its_inverse(
    body: tuple[float, ...], vehicle: tuple[float, ...], roll: float, pitch: float, yaw: float
) -> None:
    q = geometry.quat_from_euler(roll, pitch, yaw)
    ned = geometry.body_to_global(body, vehicle, q)
    np.testing.assert_allclose(ned, scipy_rotation(roll, pitch, yaw).apply(body) + vehicle, atol=1e-8)
    np.testing.assert_allclose(geometry.global_to_body(ned, vehicle, q), body, atol=1e-8)
    np.testing.assert_allclose(geometry.body_to_global([body, body], vehicle, q), [ned, ned], atol=1e-9)


def test_polar_signs_by_hand() -> None:
    np.testing.assert_allclose(geometry.polar_to_body(10.0, 0.0), [10.0, 0.0, 0.0])
    np.testing.assert_allclose(geometry.polar_to_body(10.0, math.pi / 2), [0.0, 10.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(geometry.polar_to_body(2.0, 0.0, math.pi / 6), [math.sqrt(3.0), 0.0, -1.0])
    assert geometry.polar_to_body(np.ones((4, 1)), np.zeros(3)).shape == (4, 3, 3)


@given(st.floats(0.1, 1e3), st.floats(-3.1, 3.1), st.floats(-1.5, 1.5))
def test_polar_coordinates_come_back(range_m: float, bearing: float, elevation: float) -> None:
    back = geometry.body_to_polar(geometry.polar_to_body(range_m, bearing, elevation))
    np.testing.assert_allclose(back, [range_m, bearing, elevation], rtol=1e-9, atol=1e-12)


@given(st.floats(-100.0, 100.0))
def test_wrapped_angles(value: float) -> None:
    wrapped = float(geometry.wrap_angle(value))
    assert -math.pi <= wrapped < math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(value), abs=1e-12)
    assert math.sin(wrapped) == pytest.approx(math.sin(value), abs=1e-12)


def test_the_half_turn_belongs_to_the_lower_end() -> None:
    np.testing.assert_array_equal(geometry.wrap_angle([math.pi, -math.pi]), [-math.pi, -math.pi])


@given(angle, angle, angle, angle, angle, angle, st.floats(0.0, 1.0))
def test_slerp_agrees_with_scipy(r0: float, p0: float, y0: float, r1: float, p1: float, y1: float, f: float) -> None:
    first, second = scipy_rotation(r0, p0, y0), scipy_rotation(r1, p1, y1)
    if (first.inv() * second).magnitude() > math.pi - 1e-3:
        return  # the shorter way is not defined for half a turn
    found = np.array(quaternion.slerp(quaternion.from_euler(r0, p0, y0), quaternion.from_euler(r1, p1, y1), f))
    expected = Slerp([0, 1], Rotation.concatenate([first, second]))(f).as_quat(scalar_first=True)
    assert abs(abs(float(found @ expected)) - 1.0) < 1e-9
    assert abs(float(np.linalg.norm(found)) - 1.0) < 1e-12


def test_slerp_of_equal_and_opposite_quaternions() -> None:
    w, x, y, z = q = quaternion.from_euler(0.1, 0.2, 0.3)
    np.testing.assert_allclose(quaternion.slerp(q, q, 0.5), q, atol=1e-15)
    np.testing.assert_allclose(np.abs(np.dot(quaternion.slerp(q, (-w, -x, -y, -z), 0.5), q)), 1.0)


def test_one_attitude_is_turned_to_the_bit_as_it_is_among_others() -> None:
    attitudes = geometry.quat_from_euler(*np.random.default_rng(1).uniform(-3.0, 3.0, (3, 500)))
    assert (np.array([geometry.rotation_matrix(q) for q in attitudes]) == geometry.rotation_matrix(attitudes)).all()
