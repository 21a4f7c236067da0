"""CAN frames to poses, without I/O: frames are packed here by hand by the mapping of config/ins.eds."""

import itertools
import math
import re
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.spatial.transform import Rotation

from ods.base.clock import NS
from ods.base.frames.geometry import euler_from_quat, quat_from_euler
from ods.nav_bridge.canopen.eds import EdsError
from ods.nav_bridge.canopen.object_map import object_map
from ods.nav_bridge.canopen.pdo_layout import ODD_BYTES, PdoLayout, load_pdo_set
from ods.nav_bridge.clocks.utc import WallClock
from ods.nav_bridge.settings import POSE_OBJECTS
from ods.pose.buffer import PoseBuffer
from tests.nav_bridge.canopen_samples import DAY_MS, EDS, IDS, MS, PERIOD, UTC_OFFSET, Bench, lost, pdos


def test_an_epoch_becomes_a_pose() -> None:
    bench = Bench()
    (pose,) = bench.epoch(1)
    assert pose.position_ned == pytest.approx((12.345, -6.789, 4.2))
    assert pose.velocity_body == pytest.approx((1.5, -0.02, 0.035))
    assert pose.sigma_position_ned == pytest.approx((0.25, 0.25, 0.04))
    assert pose.sigma_attitude == pytest.approx((0.003, 0.003, 0.0123))
    expected = Rotation.from_euler("ZYX", [-3.1, 0.1047, -0.0523]).as_quat(scalar_first=True)
    assert abs(float(expected @ pose.attitude)) == pytest.approx(1.0)
    assert pose.t_ns == PERIOD + 250_000
    assert pose.utc_ns == pose.t_ns + UTC_OFFSET
    assert lost(bench.counters) == {}


@pytest.mark.parametrize("pitch", [-15_708, 15_708])
@pytest.mark.parametrize("yaw", [-31_416, -7_000, 31_416])
def test_a_vertical_vehicle_has_the_attitude_that_the_ins_sends(pitch: int, yaw: int) -> None:
    """Right angles and half turns that were rounded up to whole counts."""
    (pose,) = Bench().epoch(1, roll=3_000, pitch=pitch, yaw=yaw)
    expected = Rotation.from_euler("ZYX", [1e-4 * yaw, math.copysign(math.pi / 2.0, pitch), 0.3])
    assert (Rotation.from_quat(pose.attitude, scalar_first=True).inv() * expected).magnitude() < 1e-4


@pytest.mark.parametrize("pitch_deg", [-90.0, -89.9999, 0.0, 89.9999, 90.0])
def test_what_the_ins_makes_of_an_attitude_is_that_attitude(pitch_deg: float) -> None:
    """At a right angle its angles are any pair of roll and yaw: the quaternion is the same within a count of each."""
    for yaw_deg in (-180.0, -90.0, 0.0, 40.0, 179.999):
        true = quat_from_euler(0.4, math.radians(pitch_deg), math.radians(yaw_deg))
        roll, pitch, yaw = (round(float(angle) * 1e4) for angle in euler_from_quat(true))
        (pose,) = Bench().epoch(1, roll=roll, pitch=pitch, yaw=yaw)
        turned = Rotation.from_quat(pose.attitude, scalar_first=True).inv() * Rotation.from_quat(
            true, scalar_first=True
        )
        assert turned.magnitude() < 1.6e-4


def test_between_179_and_minus_179_degrees_the_heading_is_south() -> None:
    bench, buffer = Bench(), PoseBuffer(10, 0.3)
    for number, yaw in ((1, 31_242), (2, -31_242)):
        (pose,) = bench.epoch(number, roll=0, pitch=0, yaw=yaw)
        buffer.insert(pose)
    found = buffer.at(pose.t_ns - PERIOD // 2)
    assert found is not None
    ahead = Rotation.from_quat(found.attitude, scalar_first=True).apply([1.0, 0.0, 0.0])
    np.testing.assert_allclose(ahead, [-1.0, 0.0, 0.0], atol=1e-4)


def test_instants_follow_the_ins_clock_not_the_jitter_of_arrival() -> None:
    bench = Bench()
    poses = [pose for number in range(1, 200) for pose in bench.epoch(number)]
    assert [pose.seq for pose in poses] == list(range(199))
    late = [bench.take(can_id, data, 200 * PERIOD + 7 * MS) for can_id, data in zip(IDS, pdos(200), strict=True)][-1]
    assert late is not None
    assert late.t_ns - poses[-1].t_ns == pytest.approx(PERIOD, abs=20_000)


def test_midnight_is_no_event() -> None:
    bench = Bench()
    poses = []
    for number in range(1, 50):
        ms = DAY_MS - 250 + number * 10
        poses += bench.epoch(number, ms=ms % DAY_MS, days=15_000 + ms // DAY_MS)
    steps = {b.t_ns - a.t_ns for a, b in itertools.pairwise(poses)}
    assert len(poses) == 49
    assert all(abs(step - PERIOD) < 20_000 for step in steps)
    assert lost(bench.counters) == {}


@pytest.mark.parametrize("place", [1, 2, 3, 4, 5, 6])
def test_an_epoch_that_misses_a_pdo_gives_no_pose(place: int) -> None:
    bench = Bench()
    assert len(bench.epoch(1)) == 1
    assert bench.epoch(2, only=tuple(n for n in range(1, 7) if n != place)) == []
    assert len(bench.epoch(3)) == 1
    assert bench.counters["epoch_torn"] == 1


def test_the_ins_stops_in_mid_epoch_and_starts_again() -> None:
    bench = Bench()
    assert len(bench.epoch(1)) == 1
    assert bench.epoch(2, only=(1, 2, 3)) == []
    assert len(bench.epoch(300)) == 1
    assert lost(bench.counters) == {"epoch_torn": 1, "epoch_missing": 300 - 2 - 1}


def test_no_epoch_is_put_together_from_two_that_look_alike() -> None:
    bench = Bench()
    assert bench.epoch(2, only=(1, 2, 3)) == []
    assert bench.epoch(2 + 256, only=(4, 5, 6)) == []  # same sequence number, 2.56 s later
    bench = Bench()
    assert bench.epoch(1, only=(1, 3, 4, 5, 6)) == []
    assert bench.epoch(2, only=(2,)) == []  # the position of the next epoch must not complete the last one
    assert bench.counters["pdo_stray"] == 1


@given(st.lists(st.tuples(st.integers(1, 40), st.integers(0, 5)), max_size=150))
@settings(max_examples=60)
def test_whatever_is_lost_repeated_or_swapped_a_pose_is_never_a_mixture(order: list[tuple[int, int]]) -> None:
    bench = Bench()
    for step, (number, place) in enumerate(order):
        data = pdos(number, n=number, e=number, d=number, u=number, roll=number)[place]
        pose = bench.take(IDS[place], data, NS + step * MS)
        if pose is not None:
            assert len({round(1e3 * x) for x in (*pose.position_ned, pose.velocity_body[0])}) == 1


def test_gaps_and_restarts_of_the_sequence_are_distinguished() -> None:
    bench = Bench()
    for number in (250, 251, 254, 257):  # 257 is sent as 1
        assert len(bench.epoch(number)) == 1
    assert lost(bench.counters) == {"epoch_missing": 4}
    assert len(bench.epoch(258, sequence=0)) == 1
    assert lost(bench.counters) == {"epoch_missing": 4, "sequence_reset": 1}


@pytest.mark.parametrize("missing", [1, 127, 128, 199, 255, 256, 258, 700])
def test_however_many_epochs_are_lost_time_tells_the_wraps_of_the_number(missing: int) -> None:
    bench = Bench()
    for number in range(1, 11):
        bench.epoch(number)
    bench.epoch(10 + missing + 1)
    assert lost(bench.counters) == {"epoch_missing": missing}


def test_a_repeated_epoch_is_no_new_pose() -> None:
    bench = Bench()
    assert len(bench.epoch(1)) == 1
    assert bench.epoch(1) == []
    assert len(bench.epoch(2)) == 1
    assert lost(bench.counters) == {"pdo_duplicate": 5, "pdo_stray": 1}


def test_short_and_extended_frames_are_counted_and_dropped() -> None:
    bench = Bench()
    for can_id, data in zip(IDS, pdos(1), strict=True):
        assert bench.take(can_id, data[:-1], PERIOD) is None
        assert bench.take(can_id, b"", PERIOD) is None
        assert bench.take(can_id, data, PERIOD, extended=True) is None
    assert lost(bench.counters) == {"pdo_short": 12, "can_extended": 6}
    assert len(bench.epoch(2)) == 1


@settings(max_examples=40)
@given(st.lists(st.tuples(st.integers(0, 0x7FF) | st.sampled_from(IDS), st.binary(max_size=8), st.booleans())))
def test_arbitrary_frames_do_no_harm(frames: list[tuple[int, bytes, bool]]) -> None:
    bench = Bench()
    for step, (can_id, data, extended) in enumerate(frames):
        bench.take(can_id, data, step * MS, extended)
    assert all(math.isfinite(len(text)) for text in bench.source.problems(NS))
    assert len(bench.epoch(1_000)) + len(bench.epoch(1_001)) >= 1


@pytest.mark.parametrize(
    ("field", "count"),
    [
        ("n", 200_000_000),
        ("e", -(2**31)),
        ("d", -200_000),
        ("d", 2**31 - 1),
        ("roll", -32_768),
        ("pitch", 16_000),
        ("u", 32_767),
    ],
)
def test_values_that_no_vehicle_has_are_dropped(field: str, count: int) -> None:
    bench = Bench()
    assert bench.epoch(1, (1, 2, 3, 4, 5, 6), **{field: count}) == []
    assert lost(bench.counters) == {"epoch_absurd": 1}
    assert any(text.startswith("poses are dropped: ") for text in bench.source.problems(0))


@pytest.mark.parametrize(("status", "part"), [(0b1110, "position"), (0b1101, "attitude"), (0b1011, "velocity")])
def test_what_the_ins_calls_not_valid_is_not_used_and_said(status: int, part: str) -> None:
    bench = Bench()
    assert bench.epoch(1, status=status) == []
    assert lost(bench.counters) == {"epoch_invalid": 1}
    assert f"the INS says that its {part} is not valid" in bench.source.problems(NS)


def test_without_a_valid_time_the_sync_before_the_epoch_is_its_instant() -> None:
    bench = Bench()
    bench.take(0x080, b"", PERIOD - MS)
    assert bench.epoch(1, status=0b0111)[0].t_ns == PERIOD - MS
    assert bench.epoch(4, status=0b0111)[0].t_ns == 4 * PERIOD + 250_000
    assert bench.epoch(5, ms=DAY_MS + 5)[0].t_ns == 5 * PERIOD + 250_000
    assert bench.counters["epoch_untimed"] == 3


def test_a_jump_of_the_ins_clock_is_counted_and_the_stream_goes_on() -> None:
    bench = Bench()
    poses = [pose for number in range(1, 100) for pose in bench.epoch(number)]
    back = [pose for number in range(100, 120) for pose in bench.epoch(number, ms=40_000_000 + number * 10)]
    assert bench.counters["ins_clock_jumps"] == 1
    assert len(back) >= 15
    assert abs(back[-1].t_ns - poses[-1].t_ns - 20 * PERIOD) < MS
    assert all(pose.t_ns <= 121 * PERIOD for pose in back)


def test_poses_that_arrive_seconds_late_are_dropped() -> None:
    bench = Bench()
    for number in range(1, 100):
        bench.epoch(number)
    late = [bench.take(can_id, data, 400 * PERIOD) for can_id, data in zip(IDS, pdos(100), strict=True)]
    assert late == [None] * 6
    assert bench.counters["epoch_late"] == 1


def test_silence_is_a_problem_in_plain_words() -> None:
    bench = Bench()
    bench.take(0x705, b"\x05", PERIOD)
    bench.epoch(1)
    assert bench.source.problems(2 * PERIOD) == []
    assert bench.source.problems(PERIOD + 1_200 * MS) == ["no pose for 1.2 s: no data arrive on the line any more"]
    bench.take(0x705, b"\x85", 130 * PERIOD)  # with the toggle bit of node guarding
    bench.epoch(130)
    assert bench.source.problems(131 * PERIOD) == []


def test_heartbeat_time_out_can_be_switched_off_and_bad_ones_do_not_count() -> None:
    bench = Bench()
    for data in (b"", b"\x05\x05", b"\x2a"):
        bench.take(0x705, data, NS)
    assert bench.counters["heartbeat_bad"] == 3
    assert "no INS heartbeat" in bench.source.problems(2 * NS)
    assert not any("heartbeat" in text for text in Bench(heartbeat_timeout_s=0.0).source.problems(9 * NS))


@pytest.mark.parametrize(("state", "word"), [(4, "stopped"), (127, "pre-operational"), (0, "starting")])
def test_an_ins_that_is_not_operational_is_reported(state: int, word: str) -> None:
    bench = Bench()
    bench.take(0x705, bytes([state]), 100 * MS)
    assert bench.source.problems(200 * MS) == [f"INS is {word}"]


def test_emergencies_are_said_bounded_and_reset() -> None:
    bench = Bench()
    bench.take(0x705, b"\x05", 0)
    for data in (b"", b"\x10\x43", bytes(7), bytes(range(9))[:9]):
        bench.take(0x085, data, MS)
    assert bench.counters["emcy_bad"] == 4
    bench.take(0x085, struct.pack("<HB5s", 0x4310, 0x09, b"hello"), MS)
    assert bench.source.problems(2 * MS) == ["INS error 0x4310 (temperature), error register 0x09"]
    for code in range(0x1000, 0x1400):
        bench.take(0x085, struct.pack("<HB5x", code, 1), MS)
    problems = bench.source.problems(2 * MS)
    assert len(problems) == 8
    assert problems[-1].startswith("INS error 0x13FF")
    bench.take(0x085, bytes(8), MS)
    assert bench.source.problems(2 * MS) == []


@pytest.mark.parametrize(
    ("ins_ahead_s", "status", "synchronized", "ahead_s", "source"),
    [
        (None, 15, True, 0.0, "clock"),
        (None, 15, False, 0.0, "unsure"),
        (0.3, 15, True, 0.0, "clock"),
        (3600.0, 15, True, 0.0, "unsure"),
        (3600.0, 15, False, 3600.0, "ins"),
        (-1e8, 15, False, -1e8, "ins"),
        (-1.2e9, 15, False, 0.0, "unsure"),  # 1985
        (3600.0, 7, False, 0.0, "unsure"),  # the INS says that its time is not valid
        (3600.0, 7, True, 0.0, "clock"),
    ],
)
def test_utc_is_that_of_the_better_clock_and_no_problem(
    ins_ahead_s: float | None, status: int, synchronized: bool, ahead_s: float, source: str
) -> None:
    bench = Bench()
    bench.take(0x705, b"\x05", 0)
    bench.wall_clock = WallClock(UTC_OFFSET, synchronized)
    if ins_ahead_s is not None:
        ms = (UTC_OFFSET + 10 * MS) // MS + round(1000 * ins_ahead_s)
        days, ms = divmod(ms - 441_763_200_000, DAY_MS)  # CiA 301 counts from 1984-01-01
        bench.take(0x100, struct.pack("<IH", ms, days), 10 * MS)
    (pose,) = bench.epoch(2, status=status)
    assert pose.utc_source == source
    assert pose.utc_ns - pose.t_ns - UTC_OFFSET == pytest.approx(ahead_s * NS, abs=MS)
    assert bench.source.problems(20 * MS) == []


def test_a_malformed_time_message_is_counted() -> None:
    bench = Bench()
    days = 14_000
    for data in (b"", bytes(5), struct.pack("<IH", DAY_MS, days)):
        bench.take(0x100, data, 10 * MS)
    assert bench.counters["time_bad"] == 3


EDS_TEXT = EDS.read_text()
OBJECTS = object_map(POSE_OBJECTS)


def fields_of(tmp_path: Path, text: str) -> list[tuple[int, tuple[str, ...]]]:
    """Return COB-ID and fields of the PDOs of an EDS."""
    file = tmp_path / "made.eds"
    file.write_text(text, encoding="utf-8-sig")
    return [(layout.cob_id, layout.fields) for layout in load_pdo_set(file, 5, OBJECTS).layouts]


def compact(text: str) -> str:
    """Return an EDS whose mapping records are in compact form."""
    sections = re.split(r"(?m)^(?=\[)", text)
    mapped = {
        index: re.findall(rf"(?ms)^\[{index}sub[1-9A-F]\].*?DefaultValue=(\S+)", text)
        for index in sorted(set(re.findall(r"(?m)^\[(1A\w\w)\]", text)))
    }
    kept = [section for section in sections if not re.match(r"\[1A", section)]
    for index, values in mapped.items():
        kept.append(
            f"[{index}]\nParameterName=m\nObjectType=8\nDataType=0x0007\nAccessType=rw\nCompactSubObj={len(values)}\n"
        )
        entries = "".join(f"{n}={value}\n" for n, value in enumerate(values, 1))
        kept.append(f"[{index}Value]\nNrOfEntries={len(values)}\n{entries}")
    return "".join(kept)


@pytest.mark.parametrize(
    "written",
    [
        lambda text: re.sub(r"(?m)^(DataType|ObjectType|SubNumber)=0x0*([0-7])$", r"\1=00\2", text),
        lambda text: re.sub(r"(?m)^PDOMapping=.*$", "PDOMapping=", text),
        lambda text: re.sub(r"(?m)^\[(\w{4})sub(\w+)\]$", r"[\1SUB\2]", text),
        lambda text: re.sub(r"(?m)^DefaultValue", "defaultvalue", text),
        lambda text: re.sub(r"(?m)^DefaultValue=\$NODEID\+(\S+)$", r"DefaultValue=\1 + $NodeId", text),
        lambda text: text + "\n[5F00]\nObjectType=0x7\nDataType=what\n[5F01sub1]\nDataType=0x7\n[Comments]\nLines=x\n",
        lambda text: text + "\n[5F00]\nDataType=0x7\nDefaultValue=nothing\nLowLimit=-\n[5F00]\nDataType=0x7\n",
        lambda text: text + "\n[1806]\nObjectType=9\n[1806sub0]\nDataType=5\nDefaultValue=2\n[1A06]\nObjectType=9\n"
        "[1A06sub0]\nDataType=5\nDefaultValue=0\n[1A06sub1]\nDataType=7\nDefaultValue=0x20110110\n",
        compact,
    ],
    ids=["octal", "empty", "SUB", "keys", "node id last", "what is not used", "twice", "mapping off", "compact"],
)  # fmt: skip
def test_an_eds_is_read_however_a_tool_writes_it(tmp_path: Path, written: Callable[[str], str]) -> None:
    assert written(EDS_TEXT) != EDS_TEXT
    assert fields_of(tmp_path, written(EDS_TEXT)) == fields_of(tmp_path, EDS_TEXT)


@pytest.mark.parametrize("bits", [24, 40, 48, 56])
@pytest.mark.parametrize("signed", [True, False])
def test_numbers_of_an_odd_count_of_bytes_are_read(bits: int, signed: bool) -> None:
    kind = {24: 0x10, 40: 0x12, 48: 0x13, 56: 0x14}[bits] + (0 if signed else 6)
    size, sign = ODD_BYTES[kind]
    assert (size, sign) == (bits // 8, signed)
    layout = PdoLayout(0, 0x185, struct.Struct(f"<1x{size}sB"), ("north", "sequence"), (0.5, 1), ((0, signed),))
    for number in (0, 1, 12345, (1 << (bits - signed)) - 1, *((-1, -(1 << (bits - 1))) if signed else ())):
        data = b"\xff" + number.to_bytes(size, "little", signed=signed) + b"\x07"
        assert layout.decode(data) == {"north": 0.5 * number, "sequence": 7}


def test_a_restricted_cob_id_is_named_before_anything_came(tmp_path: Path) -> None:
    file = tmp_path / "bare.eds"
    file.write_text(EDS_TEXT.replace("DefaultValue=$NODEID+0x180", "DefaultValue=0x180"))
    assert Bench().source.objections() == []
    bench = Bench(file)
    assert bench.source.objections() == [
        "0x180: CiA 301 reserves these COB-IDs for other services: is $NODEID missing in the EDS?"
    ]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("", "", "INI"),
        ("DefaultValue=0x20000008", "DefaultValue=0x20FF0008", "sequence"),
        ("DefaultValue=0x20110110", "DefaultValue=0x20110120", "does not fit 32 bits"),
        ("DefaultValue=0x20110110", "DefaultValue=0x20110104", "does not fit 4 bits"),
        ("DefaultValue=0x20110110", "DefaultValue=0x30000004", "0x2011:2 is mapped behind 4 bits, not whole bytes"),
        ("DefaultValue=0x20020030", "DefaultValue=0x20020020", "time of day"),
        ("DefaultValue=0x20010008", "DefaultValue=0x20010040", "0x2001"),
        ("[2011sub2]", "[3011sub2]", ""),
        (
            "DefaultValue=$NODEID+0x480",
            "DefaultValue=$NODEID+0x80000480",
            "no transmit PDO carries 0x2011:1 (roll), 0x2011:2",
        ),
        ("DefaultValue=$NODEID+0x480", "DefaultValue=$NODEID+0x20000480", "no transmit PDO carries 0x2011:1 (roll)"),
        ("DefaultValue=$NODEID+0x480\n", "", "0x1803:1"),
        ("DefaultValue=$NODEID+0x480", "DefaultValue=$NODEID+0x380", "the same COB-ID"),
        ("[2000]", "[2001]", "object 0x2000 is missing"),
        ("[2011]", "[2011]\nCompactSubObj=1000000000", "254 are the most"),
        ("[2000]", "[2000]\n[", "not a usable EDS"),
    ],
)
def test_an_eds_that_does_not_fit_is_one_line_that_says_so(tmp_path: Path, old: str, new: str, said: str) -> None:
    file = tmp_path / "bad.eds"
    file.write_text(EDS_TEXT.replace(old, new) if old else "no INI file")
    with pytest.raises(EdsError) as error:
        load_pdo_set(file, 5, OBJECTS)
    text = str(error.value)
    assert text.startswith(f"{file}: ")
    assert "\n" not in text
    assert said in text or not old


def test_an_eds_with_other_bytes_than_utf_8_is_read(tmp_path: Path) -> None:
    file = tmp_path / "latin.eds"
    file.write_bytes(EDS_TEXT.replace("VendorName=ODS project", "VendorName=Måleenhed 1°").encode("latin-1"))
    assert [layout.cob_id for layout in load_pdo_set(file, 5, OBJECTS).layouts] == list(IDS)
    with pytest.raises(EdsError, match="No such file"):
        load_pdo_set(tmp_path / "none.eds", 5, OBJECTS)


def test_an_ins_that_started_again_is_started_again() -> None:
    bench = Bench(start_ins=True)
    start = (0x000, b"\x01\x05")
    for step in range(100):  # boot-up, then silent about its state as long as nobody starts it
        t_ns = NS + step * 100 * MS
        if step % 40 == 0:
            bench.take(0x705, b"\x00", t_ns)
            bench.sent.clear()
        bench.source.tick(t_ns)
        if step % 40 == 5:
            assert start in bench.sent
            bench.take(0x705, b"\x05", t_ns)
            bench.sent.clear()
        assert step % 40 < 6 or start not in bench.sent
    assert bench.counters["ins_boot_up"] == 3


def test_pdos_show_that_an_ins_without_heartbeat_has_started() -> None:
    bench = Bench(start_ins=True, heartbeat_timeout_s=0.0)
    bench.take(0x705, b"\x00", 0)
    assert bench.source.problems(MS) == ["INS is starting"]
    bench.epoch(1)
    assert bench.source.problems(2 * PERIOD) == []
    bench.source.tick(10 * PERIOD)
    assert (0x000, b"\x01\x05") not in bench.sent
    bench.source.tick(NS)  # it was switched off and on, and says nothing
    assert (0x000, b"\x01\x05") in bench.sent


def emergencies(bench: Bench, t_ns: int) -> list[int]:
    """Return the error codes that we send within the next second."""
    bench.sent.clear()
    for step in range(10):
        bench.source.tick(t_ns + step * 100 * MS)
    return [struct.unpack_from("<H", data)[0] for can_id, data in bench.sent if can_id == 0x0A0]


def test_what_is_wrong_with_us_is_sent_as_emergencies_and_their_end_too() -> None:
    bench = Bench()
    bench.source.opened()
    bench.take(0x705, b"\x05", PERIOD)
    bench.epoch(1)
    assert emergencies(bench, 2 * PERIOD) == [0xFF01]  # 0.5 s without a pose
    bench.take(IDS[2], b"", 2 * NS)
    assert emergencies(bench, 2 * NS) == [0x8130, 0x8210]
    bench.source.opened()
    bench.take(0x720, b"\x05", 4 * NS)
    assert emergencies(bench, 4 * NS) == [0x8100, 0xFF03]
    bench.take(0x705, b"\x05", 6 * NS)
    bench.epoch(600)
    assert emergencies(bench, 6 * NS)[0] == 0


def test_an_nmt_state_is_kept_when_the_bus_comes_back_and_boot_up_is_said_once() -> None:
    bench = Bench()
    bench.source.opened()
    bench.take(0x000, b"\x02\x20", 0)  # stop node 32
    for _ in range(3):
        bench.source.opened()
    bench.source.tick(NS)
    heartbeats = [data for can_id, data in bench.sent if can_id == 0x720]
    assert heartbeats.count(b"\x00") == 1
    assert heartbeats[-1] == b"\x04"


@pytest.mark.parametrize("cob_id", ["0x100", "0x080", "0x720", "0x620"])
def test_a_pdo_with_the_identifier_of_another_service_is_refused(tmp_path: Path, cob_id: str) -> None:
    file = tmp_path / "ins.eds"
    file.write_text(EDS.read_text().replace("DefaultValue=$NODEID+0x180", f"DefaultValue={cob_id}"))
    with pytest.raises(EdsError, match=f"COB-ID 0x{int(cob_id, 16):X}, which another CANopen service needs"):
        Bench(file)
