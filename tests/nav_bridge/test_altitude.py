"""Altitude over the bottom from each source to the sonar's head: against a flat bottom and a vehicle in closed form."""

import math
import struct
from pathlib import Path

import msgspec
import pytest

from ods.base.clock import NS
from ods.base.frames.mounting import Mounting, MountingSettings
from ods.base.frames.quaternion import from_euler
from ods.messages import Pose
from ods.nav_bridge.lever_arm import LeverArm
from ods.nav_bridge.nmea.line import Line
from ods.nav_bridge.settings import HeldSettings, NmeaSettings, ValiditySettings
from ods.pose.buffer import POSITION_GROWTH, PoseBuffer
from ods.pose.head import head_of
from tests.nav_bridge import test_held as held, test_nmea as nmea
from tests.nav_bridge.test_pose_fields import ALL_LOCAL, Bench

BOTTOM_M = 40.0
"""Down coordinate of the bottom."""
STILL = (0.0, 0.0, 0.0)
HELD = {name: HeldSettings() for name in ("PLACE", "DEPTH", "DVL")}


@pytest.mark.parametrize(
    ("fields", "reported"),
    [((), (None, 0.0)), (("over_bottom",), (20.0, 0.3)), (("over_bottom", "sigma_over_bottom"), (20.0, 0.08))],
)
def test_a_pose_has_the_altitude_that_is_reported(
    fields: tuple[str, ...], reported: tuple[float | None, float]
) -> None:
    pose = Bench((*ALL_LOCAL, *fields)).make()
    assert pose is not None
    assert (pose.altitude_m, pose.sigma_altitude_m) == reported


@pytest.mark.parametrize("bad", [math.nan, math.inf, 0.0, -1.0, 500.1])
def test_an_altitude_that_is_none_costs_no_pose(bad: float) -> None:
    bench = Bench((*ALL_LOCAL, "over_bottom"))
    pose = bench.make(over_bottom=bad)
    assert pose is not None
    assert pose.altitude_m is None
    assert bench.counters == {"altitude_absurd": 1}


@pytest.mark.parametrize("bad", [math.nan, -0.1, 1e8])
def test_a_deviation_that_no_pose_may_carry_costs_the_altitude_only(bad: float) -> None:
    bench = Bench((*ALL_LOCAL, "over_bottom", "sigma_over_bottom"))
    pose = bench.make(sigma_over_bottom=bad)
    assert pose is not None
    assert pose.altitude_m is None
    assert msgspec.msgpack.decode(msgspec.msgpack.encode(pose), type=Pose) == pose


HANGS = "poses have no altitude over the bottom: 20 m constantly, although the depth changed by"


def test_an_altimeter_that_hangs_is_not_believed_once_the_vehicle_sinks(caplog: pytest.LogCaptureFixture) -> None:
    """10 Hz, 0.5 m/s down from the 10th second on: until then the bottom may as well be flat."""
    bench, reported = Bench((*ALL_LOCAL, "over_bottom")), []
    for number in range(200):
        pose = bench.make_at(number * NS // 10, down=20.0 + 0.05 * max(0, number - 100))
        assert pose is not None
        reported.append(pose.altitude_m)
    assert reported[:140] == [20.0] * 140
    assert reported[142:] == [None] * 58
    assert bench.counters == {"altitude_still": reported.count(None)}
    assert caplog.text.count(HANGS) == 1
    pose = bench.make_at(20 * NS, down=25.0, over_bottom=19.9)
    assert pose is not None
    assert pose.altitude_m == 19.9


def test_a_depth_that_steps_between_two_altitudes_is_no_altimeter_that_hangs() -> None:
    bench = Bench((*ALL_LOCAL, "over_bottom"))
    for number in range(50):
        pose = bench.make_at(number * NS // 10, down=20.0 + 10.0 * (number % 10 > 4), over_bottom=20.0 + number // 10)
        assert pose is not None
        assert pose.altitude_m is not None
    assert not bench.counters


def altimeter(folder: Path, max_age_s: float = 0.25, **changes: object) -> held.Vehicle:
    """A vehicle with an altimeter that has a message of its own."""
    text = held.TEXT.replace(
        "BO_ 2 DEPTH",
        'BO_ 8 ALTIMETER: 3 INS\n SG_ H : 0|16@1+ (0.01,0) [0|0] "m" INS\n SG_ OK : 16|8@1+ (1,0) [0|0] "" INS\n'
        "BO_ 2 DEPTH",
    )
    signals = held.ATTITUDE | held.PLACE | held.DVL | {"over_bottom": "ALTIMETER.H"}
    slots = HELD | {"ALTIMETER": HeldSettings(max_age_s=max_age_s, growth_m_s=0.4)}
    settings = held.dbc(folder, signals=signals, held=slots, **changes)
    settings.file.write_text(text)
    return held.Vehicle(settings)


def test_an_altimeter_of_its_own_rate_is_held_and_carried_on(tmp_path: Path) -> None:
    """It comes every 100 ms, then no more: poses go on without it, and nothing is wrong with them."""
    vehicle, with_it = altimeter(tmp_path), 0
    for number in range(150):
        t_ns = number * held.PERIOD
        if number % 10 == 0 and number <= 80:
            height = BOTTOM_M - held.VELOCITY[2] * t_ns / NS
            vehicle.take(8, struct.pack("<HB", round(100 * height), 1), t_ns)
        pose = vehicle.fly(number, "PLACE", "DEPTH", "DVL")
        if pose is None:
            continue
        number = round(pose.t_ns / held.PERIOD)
        if number - 80 > 25:
            assert pose.altitude_m is None
        elif pose.altitude_m is not None:
            with_it += 1
            assert pose.altitude_m == pytest.approx(BOTTOM_M - pose.position_ned[2], abs=0.02)
            age_s = 0.01 * (number - min(number // 10 * 10, 80))
            assert pose.sigma_altitude_m == pytest.approx(math.hypot(0.3, 0.4 * age_s), abs=0.005)
    assert with_it > 95
    assert vehicle.source.problems(150 * held.PERIOD) == []


def test_a_slow_altimeter_does_not_hang(tmp_path: Path) -> None:
    """Every 8 s, held for 10, while the vehicle sinks by 4 m from one to the next."""
    vehicle, with_it = altimeter(tmp_path, max_age_s=10.0), 0
    for number in range(2400):
        t_ns = number * held.PERIOD
        if number % 800 == 0:
            vehicle.take(8, struct.pack("<HB", round(100 * (BOTTOM_M - held.VELOCITY[2] * t_ns / NS)), 1), t_ns)
        pose = vehicle.fly(number, "PLACE", "DEPTH", "DVL")
        with_it += pose is not None and pose.altitude_m is not None
    assert with_it == 2399
    assert not vehicle.counters["altitude_still"]


def test_a_status_of_the_altimeter_costs_the_altitude_only(tmp_path: Path) -> None:
    vehicle = altimeter(tmp_path, valid=[ValiditySettings(signal="ALTIMETER.OK", accept=[1], says="altitude")])
    reported = []
    for number in range(80):
        good = number < 40
        vehicle.take(8, struct.pack("<HB", 3000, good), number * held.PERIOD)
        pose = vehicle.fly(number, "PLACE", "DEPTH", "DVL")
        reported += [] if pose is None else [pose.altitude_m is not None]
    assert reported == [True] * (39 + 25) + [False] * (len(reported) - 64)
    assert len(reported) == 79
    assert vehicle.source.problems(80 * held.PERIOD) == []


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("BD", b":BD,+1.0,-2.0,+0.1,12.34,0.0"), ("DPT", nmea.summed("SDDPT,12.34,0.5")),
     ("SDDBT", nmea.summed("SDDBT,40.5,f,12.34,M,6.7,F"))],
)  # fmt: skip
def test_nmea_and_pd6(name: str, sentence: bytes) -> None:
    source, _ = nmea.source_of(msgspec.structs.replace(nmea.USUAL, altitude=name, accuracy=None))
    ins = nmea.Ins()
    for line in (ins.gga(0), ins.ts(0), ins.bs(), ins.pashr(0)):
        pose = source.take(Line(line, 0))
    assert pose is not None  # a pose does not wait for it
    assert pose.altitude_m is None
    source.take(Line(sentence, 0))
    pose = source.take(Line(ins.pashr(0), 0))
    assert pose is not None
    assert pose.altitude_m == 12.34
    assert pose.position_ned[2] == pytest.approx(ins.place(0)[2], abs=1e-3)
    assert source.problems(NS // 10) == []


def test_one_sentence_does_not_tell_depth_and_altitude() -> None:
    with pytest.raises(ValueError, match=r"^altitude: SDDPT is already used for the depth"):
        NmeaSettings(port="/dev/null", depth="DPT", altitude="SDDPT")


def pose(t_s: float, altitude_m: float | None, velocity: tuple[float, float, float] = STILL) -> Pose:
    attitude = from_euler(0.1, -0.2, 0.7)
    return Pose(
        0, round(t_s * NS), 0, (0.0, 0.0, 30.0), attitude, velocity, STILL, STILL,
        altitude_m=altitude_m, sigma_altitude_m=0.5,
    )  # fmt: skip


def test_origin_and_head_are_as_high_over_the_bottom_as_they_lie_above_each_other() -> None:
    reported = pose(0.0, 10.0)
    origin = LeverArm((2.0, -1.0, 0.5)).at_origin(reported)
    buffer = PoseBuffer(10, 0.5)
    buffer.insert(origin)
    head = head_of(buffer.at(0), Mounting(MountingSettings(position_m=(3.0, 0.5, 1.0))))
    assert origin.altitude_m is not None
    assert head is not None
    assert head.altitude_m is not None
    bottom = reported.position_ned[2] + 10.0
    assert origin.position_ned[2] + origin.altitude_m == pytest.approx(bottom)
    assert head.position_ned[2] + head.altitude_m == pytest.approx(bottom)
    assert abs(head.altitude_m - 10.0) > 0.3


def test_between_poses_and_beyond_them() -> None:
    buffer = PoseBuffer(10, 0.5)
    level = msgspec.structs.replace(pose(0.1, 8.0, (0.0, 0.0, 1.5)), attitude=(1.0, 0.0, 0.0, 0.0))
    for each in (pose(0.0, 9.0), level):
        buffer.insert(each)
    between, beyond = buffer.at(round(0.025 * NS)), buffer.at(round(0.3 * NS))
    assert between is not None
    assert beyond is not None
    assert between.altitude_m == pytest.approx(8.75)
    assert between.sigma_altitude_m == 0.5
    assert beyond.altitude_m == pytest.approx(8.0 - 1.5 * 0.2)  # it sinks
    assert beyond.sigma_altitude_m == pytest.approx(math.hypot(0.5, POSITION_GROWTH * 0.2))
    buffer.insert(pose(0.2, None))
    gap = buffer.at(round(0.15 * NS))
    assert gap is not None
    assert gap.altitude_m is None


@pytest.mark.parametrize("bad", [{"altitude_m": math.nan}, {"sigma_altitude_m": -0.1}, {"sigma_altitude_m": math.inf}])
def test_a_bad_altitude_off_the_bus_is_a_bad_pose(bad: dict[str, float]) -> None:
    buffer = PoseBuffer(10, 0.5)
    buffer.insert(msgspec.structs.replace(pose(0.0, 9.0), **bad))
    assert buffer.counters == {"pose_bad": 1}
