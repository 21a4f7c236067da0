import math
import random

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from ods.clock import NS
from ods.messages import Pose, Quaternion
from ods.pose_buffer import ATTITUDE_GROWTH, POSITION_GROWTH, PoseBuffer

MS = 1_000_000


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    w, x, y, z = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat(scalar_first=True).tolist()
    return w, x, y, z


def pose_at(t_s: float, yaw_rate: float = 0.35, yaw0: float = 0.0, pitch: float = 0.1) -> Pose:
    """A pose on a steady turn at 2 m/s."""
    return Pose(
        seq=0,
        t_ns=round(t_s * NS),
        utc_ns=0,
        position_ned=(2.0 * t_s, -t_s, 4.0),
        attitude=quaternion(0.05, pitch, yaw0 + yaw_rate * t_s),
        velocity_body=(2.0, 0.1, 0.0),
        sigma_position_ned=(0.1, 0.2, 0.3),
        sigma_attitude=(0.01, 0.02, 0.03),
    )


def rotation(q: np.ndarray | Quaternion) -> Rotation:
    return Rotation.from_quat(np.asarray(q), scalar_first=True)


def angle_between(a: np.ndarray | Quaternion, b: np.ndarray | Quaternion) -> float:
    return float((rotation(a).inv() * rotation(b)).magnitude())


angles = st.floats(-math.pi, math.pi)


@settings(max_examples=50)
@given(angles, angles, angles, angles, angles, angles, st.integers(0, 10 * MS))
def test_interpolation_agrees_with_scipy(
    r0: float, p0: float, y0: float, r1: float, p1: float, y1: float, t: int
) -> None:
    a = msgspec.structs.replace(pose_at(0.0), attitude=quaternion(r0, p0, y0))
    b = msgspec.structs.replace(pose_at(0.01), attitude=quaternion(r1, p1, y1), velocity_body=(1.0, 0.0, -1.0))
    buffer = PoseBuffer(10, 0.5)
    buffer.insert(a)
    buffer.insert(b)
    found = buffer.at(t)
    assert found is not None
    f = t / (10 * MS)
    arc = angle_between(a.attitude, b.attitude)
    if arc < math.pi - 1e-3:  # the shorter way is not defined for half a turn
        expected = Slerp([0, 1], Rotation.concatenate([rotation(a.attitude), rotation(b.attitude)]))(f)
        assert (rotation(found.attitude).inv() * expected).magnitude() < 1e-6
        velocity = expected.apply((1.0 - f) * np.array(a.velocity_body) + f * np.array(b.velocity_body))
        np.testing.assert_allclose(found.velocity_ned, velocity, atol=1e-5)
    np.testing.assert_allclose(found.position_ned, [0.02 * f, -0.01 * f, 4.0], atol=1e-12)
    np.testing.assert_allclose(found.sigma_position, [0.1, 0.2, 0.3])
    assert abs(np.linalg.norm(found.attitude) - 1.0) < 1e-12
    assert found.extrapolated_s == 0.0


def test_yaw_across_180_degrees_takes_the_short_way() -> None:
    buffer = PoseBuffer(10, 0.5)
    for t_s, yaw_deg in ((0.0, 179.0), (0.01, -179.0)):
        buffer.insert(msgspec.structs.replace(pose_at(t_s), attitude=quaternion(0.0, 0.0, math.radians(yaw_deg))))
    found = buffer.at(5 * MS)
    assert found is not None
    assert angle_between(found.attitude, quaternion(0.0, 0.0, math.pi)) < 1e-9


@pytest.mark.parametrize("pitch_deg", [-90.0, 90.0])
def test_pitch_of_90_degrees_is_no_special_case(pitch_deg: float) -> None:
    buffer = PoseBuffer(10, 0.5)
    for t_s in (0.0, 0.01):
        buffer.insert(pose_at(t_s, pitch=math.radians(pitch_deg)))
    found = buffer.at(4 * MS)
    assert found is not None
    expected = pose_at(0.004, pitch=math.radians(pitch_deg)).attitude
    assert angle_between(found.attitude, expected) < 1e-6


def test_a_quaternion_and_its_negative_are_the_same_attitude() -> None:
    buffer = PoseBuffer(10, 0.5)
    buffer.insert(pose_at(0.0))
    late = pose_at(0.01)
    w, x, y, z = late.attitude
    buffer.insert(msgspec.structs.replace(late, attitude=(-w, -x, -y, -z)))
    found = buffer.at(5 * MS)
    assert found is not None
    assert angle_between(found.attitude, pose_at(0.005).attitude) < 1e-9


def test_order_of_arrival_does_not_matter() -> None:
    poses = [pose_at(0.01 * n) for n in range(100)]
    shuffled = random.Random(5).sample(poses, len(poses))
    ordered, mixed = PoseBuffer(200, 0.5), PoseBuffer(200, 0.5)
    for a, b in zip(poses, shuffled, strict=True):
        ordered.insert(a)
        mixed.insert(b)
    for t_ns in range(0, NS, 7 * MS):
        a_found, b_found = ordered.at(t_ns), mixed.at(t_ns)
        assert a_found is not None
        assert b_found is not None
        np.testing.assert_array_equal(a_found.attitude, b_found.attitude)
        np.testing.assert_array_equal(a_found.position_ned, b_found.position_ned)


def test_extrapolation_carries_velocity_and_turn_on_with_growing_sigma_up_to_the_limit() -> None:
    buffer = PoseBuffer(100, 0.5)
    for n in range(50):
        buffer.insert(pose_at(0.01 * n))
    last = pose_at(0.49)
    dt = 0.3
    found = buffer.at(last.t_ns + round(dt * NS))
    assert found is not None
    velocity = rotation(last.attitude).apply(last.velocity_body)
    np.testing.assert_allclose(found.position_ned, np.array(last.position_ned) + velocity * dt, atol=1e-9)
    assert angle_between(found.attitude, pose_at(0.49 + dt).attitude) < 1e-6
    assert found.sigma_position[1] == pytest.approx(math.hypot(0.2, POSITION_GROWTH * dt))
    assert found.sigma_attitude[2] == pytest.approx(math.hypot(0.03, ATTITUDE_GROWTH * dt))
    assert found.extrapolated_s == pytest.approx(dt)
    assert buffer.at(last.t_ns + NS // 2) is not None
    assert buffer.at(last.t_ns + NS // 2 + 1) is None
    assert buffer.at(-NS // 2) is not None
    assert buffer.at(-NS // 2 - 1) is None


def test_one_pose_alone_is_carried_on_without_a_turn() -> None:
    buffer = PoseBuffer(10, 0.5)
    assert buffer.at(0) is None
    buffer.insert(pose_at(1.0))
    exact, later = buffer.at(NS), buffer.at(NS + 100 * MS)
    assert exact is not None
    assert later is not None
    assert exact.extrapolated_s == 0.0
    np.testing.assert_array_equal(exact.attitude, later.attitude)


def test_a_long_gap_is_not_interpolated_but_extrapolated_from_the_nearer_side() -> None:
    buffer = PoseBuffer(100, 0.5)
    for n in (*range(10), *range(210, 220)):
        buffer.insert(pose_at(0.01 * n))
    near = buffer.at(round(0.19 * NS))
    assert near is not None
    assert near.extrapolated_s == pytest.approx(0.1)
    before_the_end = buffer.at(round(2.0 * NS))
    assert before_the_end is not None
    assert before_the_end.extrapolated_s == pytest.approx(0.1)
    assert buffer.at(NS) is None


def test_what_is_not_a_pose_is_dropped_and_counted() -> None:
    good = pose_at(0.0)
    buffer = PoseBuffer(3, 0.5)
    bad: list[dict[str, object]] = [
        {"position_ned": (math.nan, 0.0, 0.0)},
        {"velocity_body": (0.0, math.inf, 0.0)},
        {"attitude": (0.0, 0.0, 0.0, 0.0)},
        {"attitude": (1.0, 0.1, 0.0, 0.0)},
        {"attitude": (math.nan, 0.0, 0.0, 0.0)},
        {"sigma_position_ned": (-1.0, 0.0, 0.0)},
        {"sigma_attitude": (0.0, math.nan, 0.0)},
    ]
    for change in bad:
        buffer.insert(msgspec.structs.replace(good, **change))
    assert len(buffer) == 0
    assert buffer.counters == {"pose_bad": len(bad)}
    for t_s in (1.0, 2.0, 3.0, 2.0, 0.5, 4.0):
        buffer.insert(pose_at(t_s))
    assert len(buffer) == 3
    assert buffer.counters == {"pose_bad": len(bad), "pose_duplicate": 1, "pose_too_old": 1}
    assert buffer.at(NS) is None
    assert buffer.at(4 * NS) is not None
