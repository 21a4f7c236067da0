"""Poses that do not hold together, each believable by itself: the list says so, and is not valid."""

import math

import msgspec
import pytest

from ods.base.clock import NS
from ods.base.frames.quaternion import from_euler
from ods.messages import Pose, Vector3
from ods.tracker.output.pose_sense import PoseSense

STEP_NS = NS // 100


def pose(t_ns: int, place: Vector3, *, yaw: float = 0.0, speed: float = 1.0, sigma_m: float = 0.1) -> Pose:
    return Pose(
        seq=0, t_ns=t_ns, utc_ns=0, position_ned=place, attitude=from_euler(0.0, 0.0, yaw),
        velocity_body=(speed, 0.0, 0.0), sigma_position_ned=(sigma_m,) * 3, sigma_attitude=(0.01,) * 3,
    )  # fmt: skip


def received(poses: list[Pose]) -> tuple[PoseSense, list[str]]:
    sense = PoseSense()
    return sense, [jump for jump in map(sense.receive, poses) if jump]


def course(
    count: int, step_ns: int = STEP_NS, speed: float = 1.0, begin_ns: int = 0, ahead_m: float = 0.0
) -> list[Pose]:
    """Return poses north at a constant speed."""
    times = [begin_ns + i * step_ns for i in range(count)]
    return [pose(t_ns, (ahead_m + speed * t_ns / NS, 0.0, 0.0), speed=speed) for t_ns in times]


def test_a_vehicle_under_way_makes_sense() -> None:
    sense, jumps = received(course(1000))
    assert not jumps
    assert sense.reasons(10 * NS) == []


def test_a_jump_is_reported_once_and_for_a_second() -> None:
    before = course(100)
    sense, jumps = received(before + course(100, begin_ns=NS, ahead_m=100.0))
    assert jumps == ["the pose jumped by 100.0 m"]
    assert sense.reasons(NS + NS // 2) == [
        "the pose jumped by 100.0 m: earlier objects are at wrong positions and are dropped"
    ]
    assert sense.reasons(2 * NS + STEP_NS) == []


def test_a_jump_over_a_gap_counts_less_the_way_the_vehicle_may_have_made() -> None:
    gap = course(10), course(10, begin_ns=20 * NS)
    assert not received(gap[0] + gap[1])[1]
    assert received(gap[0] + course(10, begin_ns=20 * NS, ahead_m=100.0))[1]


@pytest.mark.parametrize(("step_m", "jumps"), [(4.0, False), (10.0, True)])
def test_a_correction_that_noise_does_not_explain_is_a_jump_also_within_the_claim(step_m: float, jumps: bool) -> None:
    """Dead reckoning that was 10 m off gets a fix: what was tracked before lies 10 m elsewhere."""
    vague = [msgspec.structs.replace(p, sigma_position_ned=(10.0, 10.0, 1.0)) for p in course(200)]
    vague[100:] = [msgspec.structs.replace(p, position_ned=(p.position_ned[0] + step_m, 0.0, 0.0)) for p in vague[100:]]
    assert bool(received(vague)[1]) == jumps


def test_a_place_computed_once_a_second_is_no_jump() -> None:
    stairs = [pose(p.t_ns, (2.0 * (p.t_ns // NS), 0.0, 0.0), speed=2.0) for p in course(1000)]
    sense, jumps = received(stairs)
    assert not jumps
    assert sense.reasons(stairs[-1].t_ns) == []


def test_a_heading_that_flips_is_reported() -> None:
    north, south = course(100), course(100, begin_ns=NS)
    flipped = [msgspec.structs.replace(p, attitude=from_euler(0.0, 0.0, math.pi)) for p in south]
    sense, jumps = received(north + flipped)
    assert jumps == ["the pose turned by 180 deg within 0.01 s"]
    assert sense.reasons(NS + STEP_NS)


@pytest.mark.parametrize("rate_hz", [5, 100])
def test_a_fast_turn_through_south_is_none(rate_hz: int) -> None:
    turning = [
        pose(i * NS // rate_hz, (0.0, 0.0, 0.0), yaw=math.radians(90.0) * i / rate_hz) for i in range(5 * rate_hz)
    ]
    assert not received(turning)[1]


def test_a_place_that_stands_still_under_way_is_reported_until_it_moves() -> None:
    frozen = [pose(i * STEP_NS, (5.0, 0.0, 0.0)) for i in range(301)]
    sense, _ = received(frozen[:190])
    assert sense.reasons(frozen[189].t_ns) == []
    sense, _ = received(frozen)
    assert sense.reasons(3 * NS) == [
        "the position of the INS has been constant for 3.0 s, although its velocity makes 3.0 m"
    ]
    sense.receive(pose(3 * NS + STEP_NS, (8.0, 0.0, 0.0)))
    assert sense.reasons(3 * NS + STEP_NS) == []


def test_a_vehicle_at_rest_may_stand_still() -> None:
    sense, _ = received([pose(i * STEP_NS, (5.0, 0.0, 0.0), speed=0.0) for i in range(1000)])
    assert sense.reasons(10 * NS) == []


def test_poses_out_of_order_and_of_no_attitude_tell_nothing() -> None:
    mixed = course(100)
    mixed.insert(50, pose(0, (500.0, 0.0, 0.0)))
    mixed.insert(60, msgspec.structs.replace(mixed[61], attitude=(0.0, 0.0, 0.0, 0.0)))
    assert not received(mixed)[1]


def test_an_ins_that_is_still_aligning_is_not_relied_on() -> None:
    sense, _ = received([msgspec.structs.replace(p, sigma_attitude=(0.01, 0.01, math.pi)) for p in course(10)])
    assert sense.reasons(NS // 10) == [
        "the INS reports an attitude with a standard deviation of 180 deg: is it still aligning?"
    ]
    sense.receive(msgspec.structs.replace(course(11)[-1], sigma_attitude=(0.01, 0.01, 0.1)))
    assert sense.reasons(NS // 10) == []


def test_a_velocity_of_another_unit_is_reported_until_it_is_right_again() -> None:
    """Lists stay valid: objects are where they are reported to be."""
    in_kmh = [msgspec.structs.replace(p, velocity_body=(3.6, 0.0, 0.0)) for p in course(1010)]
    sense, jumps = received(in_kmh)
    assert not jumps
    assert "the position moved by 10.0, 0.0, 0.0 m within 10.0 s" in sense.disagreement
    assert sense.disagreement.endswith("is the velocity in km/h?")
    assert sense.reasons(in_kmh[-1].t_ns) == []
    for each in course(1010, begin_ns=11 * NS):
        sense.receive(each)
    assert sense.disagreement == ""


def test_a_jump_is_no_wrong_unit() -> None:
    sense, jumps = received(course(600) + course(1200, begin_ns=6 * NS, ahead_m=100.0))
    assert jumps
    assert sense.disagreement == ""


def test_a_place_that_stands_still_to_the_last_digit_is_doubtful_though_no_speed_is_reported() -> None:
    poses = [pose(i * STEP_NS, (5.0, 0.0, 0.0), yaw=0.001 * i, speed=0.0) for i in range(300)]
    sense, _ = received(poses[:150])
    assert not sense.is_doubtful
    sense, _ = received(poses)
    assert sense.is_doubtful
    assert sense.reasons(3 * NS) == []
    sense.receive(pose(300 * STEP_NS, (5.001, 0.0, 0.0), speed=0.0))
    assert not sense.is_doubtful


@pytest.mark.parametrize(("roll", "pitch", "says"), [(180.0, 0.0, True), (-95.0, 0.0, True), (0.0, 60.0, False)])
def test_a_vehicle_that_is_upside_down_is_reported(roll: float, pitch: float, says: bool) -> None:
    attitude = from_euler(math.radians(roll), math.radians(pitch), 1.0)
    sense, _ = received([msgspec.structs.replace(each, attitude=attitude) for each in course(10)])
    assert [reason for reason in sense.reasons(STEP_NS) if "upside down" in reason] == sense.reasons(STEP_NS)
    assert bool(sense.reasons(STEP_NS)) == says


@pytest.mark.parametrize(("degrees", "every", "says"), [(8.0, 2, True), (8.0, 100, False), (2.0, 2, False)])
def test_an_attitude_that_goes_to_and_fro_is_of_two_inss(degrees: float, every: int, says: bool) -> None:
    """Each step is less than a jump; a heading that is computed once a second makes one such step a second."""
    turned = from_euler(0.0, 0.0, math.radians(degrees))
    poses = course(300)
    other = [msgspec.structs.replace(p, attitude=turned) if i // (every // 2) % 2 else p for i, p in enumerate(poses)]
    sense, jumps = received(other)
    assert not jumps
    assert any("back and forth" in reason for reason in sense.reasons(other[-1].t_ns)) == says
    for each in course(110, begin_ns=3 * NS):
        sense.receive(each)
    assert sense.reasons(3 * NS + 110 * STEP_NS) == []
