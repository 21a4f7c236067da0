import math
from dataclasses import astuple

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.spatial.transform import Rotation, Slerp

from ods.base.clock import NS
from ods.messages import Pose, Quaternion
from ods.pose.buffer import ATTITUDE_GROWTH, POSITION_GROWTH, PoseBuffer

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


def test_a_flood_of_poses_is_thinned_out_and_the_newest_one_kept() -> None:
    """At 95,000 a second 400 of them would reach back for 4 ms only; late ones are thinned out likewise."""
    buffer = PoseBuffer(400, 0.3, max_rate_hz=250.0)
    count = 100_000
    still = pose_at(0.0)
    for k in range(count):
        t_s = k / 95_000.0
        buffer.insert(msgspec.structs.replace(still, t_ns=round(t_s * NS), position_ned=(2.0 * t_s, 0.0, 0.0)))
        assert buffer._times[-1] == round(t_s * NS)
    found = buffer.at(round(0.5 * NS))
    assert found is not None
    assert found.extrapolated_s == 0.0
    assert found.position_ned[0] == pytest.approx(1.0, abs=1e-6)
    assert min(np.diff(buffer._times[:-1])) >= NS // 250
    assert buffer.counters["pose_thinned"] + len(buffer) == count
    buffer.insert(msgspec.structs.replace(still, t_ns=NS // 2 + 7))
    assert buffer.counters["pose_thinned"] + len(buffer) == count + 1


def test_poses_that_come_at_a_usual_rate_are_all_kept() -> None:
    rng = np.random.default_rng(3)
    buffer = PoseBuffer(400, 0.3, max_rate_hz=250.0)
    for t_s in np.arange(200) / 100.0 + rng.uniform(-2e-3, 2e-3, 200):
        buffer.insert(pose_at(float(t_s)))
    assert len(buffer) == 200
    assert not buffer.counters


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


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_loop_goes_through_the_vertical(sign: float) -> None:
    """From 89 deg on one side to 89 deg on the other, where roll and yaw have jumped by half a turn; and on."""
    up, side = math.radians(89.0) * sign, math.radians(1.0) * sign
    buffer = PoseBuffer(10, 0.5)
    for t_s, euler in ((0.0, (0.0, up, 0.3)), (0.01, (math.pi, up, 0.3 - math.pi))):
        buffer.insert(msgspec.structs.replace(pose_at(t_s), attitude=quaternion(*euler)))
    for t_ms, turned in ((5, side), (10, 2.0 * side), (20, 4.0 * side)):
        found = buffer.at(t_ms * MS)
        assert found is not None
        expected = rotation(quaternion(0.0, up, 0.3)) * Rotation.from_rotvec([0.0, turned, 0.0])
        assert (rotation(found.attitude).inv() * expected).magnitude() < 1e-6


def test_a_turn_is_carried_on_across_180_degrees() -> None:
    buffer = PoseBuffer(20, 0.5)
    for n in range(11):
        buffer.insert(pose_at(0.01 * n, yaw0=math.radians(177.9)))  # 179.9 deg at the end
    found = buffer.at(200 * MS)
    assert found is not None
    assert angle_between(found.attitude, pose_at(0.2, yaw0=math.radians(177.9)).attitude) < 1e-6


def test_a_quaternion_and_its_negative_are_the_same_attitude() -> None:
    buffer = PoseBuffer(10, 0.5)
    buffer.insert(pose_at(0.0))
    late = pose_at(0.01)
    w, x, y, z = late.attitude
    buffer.insert(msgspec.structs.replace(late, attitude=(-w, -x, -y, -z)))
    found = buffer.at(5 * MS)
    assert found is not None
    assert angle_between(found.attitude, pose_at(0.005).attitude) < 1e-9


@settings(max_examples=60)
@given(st.permutations(range(12)), st.integers(1, 15), st.lists(st.integers(1, 90), min_size=12, max_size=12))
def test_order_of_arrival_does_not_matter(order: list[int], capacity: int, gaps_ms: list[int]) -> None:
    """Nor which poses a full buffer has to drop: it keeps the newest."""
    times = np.cumsum(gaps_ms).tolist()
    poses = [pose_at(1e-3 * t_ms) for t_ms in times]
    ordered, mixed = PoseBuffer(capacity, 0.05), PoseBuffer(capacity, 0.05)
    for number, pose in zip(order, poses, strict=True):
        ordered.insert(pose)
        mixed.insert(poses[number])
    assert len(ordered) == len(mixed) == min(capacity, len(poses))
    for t_ms in range(times[0] - 60, times[-1] + 70, 5):
        a, b = ordered.at(t_ms * MS), mixed.at(t_ms * MS)
        assert (a is None) == (b is None)
        if a is not None and b is not None:
            for one, other in zip(astuple(a), astuple(b), strict=True):
                np.testing.assert_array_equal(one, other)


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


def test_uncertainty_grows_with_the_time_to_the_nearest_pose() -> None:
    buffer = PoseBuffer(100, 0.5)
    for n in range(20):
        buffer.insert(pose_at(0.01 * n))
    for edge_ns, way in ((0, -1), (190 * MS, 1)):
        found = [buffer.at(edge_ns + way * t * MS) for t in range(0, 501, 20)]
        for get in ("sigma_position", "sigma_attitude", "extrapolated_s"):
            growing = np.array([getattr(one, get) for one in found])
            assert (np.diff(growing, axis=0) > 0.0).all()


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
        {"attitude": (0.0, 0.0, 0.0, 0.0)},
        {"attitude": (1.0, 0.1, 0.0, 0.0)},
        {"sigma_position_ned": (-1.0, 0.0, 0.0)},
        {"sigma_attitude": (0.0, 0.0, -1e-9)},
        {"position_ned": (math.inf, -math.inf, 0.0)},
    ]
    for field in ("position_ned", "attitude", "velocity_body", "sigma_position_ned", "sigma_attitude"):
        numbers = getattr(good, field)
        for place in range(len(numbers)):
            bad += [{field: (*numbers[:place], x, *numbers[place + 1 :])} for x in (math.nan, math.inf, -math.inf)]
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
