"""What a DBC file, J1939 or NMEA 2000 keeps for "not available" makes no pose, and is said by name."""

from collections import Counter
from pathlib import Path

import cantools
import pytest
from hypothesis import given, strategies as st

from ods.base.clock import MS, NS
from ods.base.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.can.frame import CanId, Frame
from ods.nav_bridge.clocks.utc import Utc, WallClock
from ods.nav_bridge.dbc.file import DbcError
from ods.nav_bridge.dbc.no_value import no_value_of
from ods.nav_bridge.dbc.signal_map import load_dbc_map
from ods.nav_bridge.dbc.source import DbcSource
from ods.nav_bridge.settings import DbcSettings, NavSettings
from ods.nav_bridge.source import SourceHost

HEAD = 'VERSION ""\nNS_ :\nBS_:\nBU_: INS\n'
ONE = """BO_ {number} INS: 8 INS
 SG_ YAW : 0|{bits}@1{sign} ({scale},0) {span} "rad" X
"""
EXTENDED = 1 << 31
POSE = """BO_ {ins} INS: 8 INS
 SG_ YAW : 0|16@1- (0.0001,0) [-3.2|3.2] "rad" X
 SG_ ROLL : 16|16@1- (0.0001,0) [-3.2|3.2] "rad" X
 SG_ PITCH : 32|16@1- (0.0001,0) [-1.6|1.6] "rad" X
 SG_ N : 48|16@1- (1,0) [0|0] "m" X
BO_ 257 REST: 8 INS
 SG_ E : 0|16@1- (1,0) [0|0] "m" X
 SG_ D : 16|8@1+ (1,0) [0|600] "m" X
 SG_ U : 24|8@1- (0.1,0) [0|0] "m/s" X
 SG_ V : 32|8@1- (0.1,0) [0|0] "m/s" X
 SG_ W : 40|8@1- (0.1,0) [0|0] "m/s" X
"""
SIGNALS: dict[str, str] = {
    "yaw": "INS.YAW", "roll": "INS.ROLL", "pitch": "INS.PITCH", "north": "INS.N", "east": "REST.E", "down": "REST.D",
    "u": "REST.U", "v": "REST.V", "w": "REST.W",
}  # fmt: skip


def signal_of(bits: int, sign: str, span: str = "[0|0]", more: str = "") -> "cantools.database.can.Signal":
    text = HEAD + ONE.format(number=EXTENDED | 0x19F11223, bits=bits, sign=sign, scale=1, span=span) + more
    database = cantools.database.load_string(text, "dbc")
    return database.messages[0].signals[0]  # type: ignore[union-attr]


@given(st.integers(4, 64), st.booleans(), st.booleans())
def test_the_highest_raw_values_of_every_width_are_none(bits: int, is_signed: bool, j1939: bool) -> None:
    reported = no_value_of(signal_of(bits, "-" if is_signed else "+"), extended=True, j1939=j1939)
    most = (1 << (bits - is_signed)) - 1
    assert all(reported.why(raw) for raw in (most, most - 1, most - 2))
    first = 0xFB << (bits - 8) if j1939 and not is_signed and bits % 8 == 0 else most - 2
    assert reported.why(first)
    assert not reported.why(first - 1)
    assert not reported.why(0)
    assert not any(no_value_of(signal_of(bits, "+"), extended=False, j1939=False).why(raw) for raw in (0, most))


@pytest.mark.parametrize(
    "name", ["not available", "SNA", "N/A", "Error", "invalid", "Signal_Not_Valid", "No Data", "fault"]
)
def test_a_name_that_says_so_makes_a_raw_value_none(name: str) -> None:
    signal = signal_of(16, "+", more=f'VAL_ {EXTENDED | 0x19F11223} YAW 4660 "{name}" 4661 "North" 4662 "standby" ;\n')
    reported = no_value_of(signal, extended=False, j1939=False)
    assert reported.why(4660) == f'"{name}"'
    assert not reported.why(4661)
    assert not reported.why(4662)


def test_a_value_outside_of_the_dbcs_range_is_none_unless_the_range_is_not_believed() -> None:
    signal = signal_of(16, "-", "[-180|180]")
    reported = no_value_of(signal, extended=False, j1939=False)
    assert reported.why(200) == "200 rad, outside of the DBC's range"
    assert reported.why(-200)
    assert not any(reported.why(raw) for raw in (-180, -181, 0, 180, 181))  # ends are rounded
    assert not no_value_of(signal, extended=False, j1939=False, any_value=True).why(200)


def source_of(tmp_path: Path, ins: int, more: str = "", sender: int | None = None) -> tuple[DbcSource, Counter[str]]:
    file = tmp_path / "x.dbc"
    file.write_bytes(b"\xef\xbb\xbf" + (HEAD + POSE.format(ins=ins) + more).encode())
    counters: Counter[str] = Counter()
    settings = DbcSettings(file=file, signals=dict(SIGNALS), epoch=["INS", "REST"], source_address=sender)
    host = SourceHost(
        LocalFrame(57.0, 10.0), lambda *_: None, counters, 0, Utc(lambda: WallClock(0, synchronized=True))
    )
    return DbcSource(NavSettings(source="dbc", dbc=settings), settings, host), counters


def ins_frame(can_id: int, t_ns: int, yaw: int = 5000) -> Frame:
    data = b"".join(number.to_bytes(2, "little", signed=True) for number in (yaw, 100, -100, 7))
    return Frame(can_id, True, data, t_ns)


def rest_frame(t_ns: int) -> Frame:
    return Frame(257, False, bytes([3, 0, 20, 15, 0, 0, 0, 0]), t_ns)


def fly(source: DbcSource, *senders: int, yaw: int = 5000) -> list[Pose]:
    """Send a second of instants, of each sender in turn."""
    poses = []
    for k in range(1, 51):
        t_ns = k * 20 * MS
        frames = [*(ins_frame(can_id, t_ns, yaw) for can_id in senders), rest_frame(t_ns + MS)]
        poses += [pose for frame in frames if (pose := source.take(frame)) is not None]
    return poses


def test_a_signal_without_a_value_makes_no_pose_and_is_said(tmp_path: Path) -> None:
    source, counters = source_of(tmp_path, EXTENDED | 0x19F11223)
    assert len(fly(source, 0x19F11223)) > 40
    assert not fly(source_of(tmp_path, EXTENDED | 0x19F11223)[0], 0x19F11223, yaw=0x7FFF)
    source, counters = source_of(tmp_path, EXTENDED | 0x19F11223)
    fly(source, 0x19F11223, yaw=0x7FFF)
    assert counters["epoch_invalid"] > 40
    assert any(p.startswith("INS.YAW is raw 0x7FFF") for p in source.problems(2 * NS))


def test_of_j1939_the_parameter_group_counts_not_priority_and_sender(tmp_path: Path) -> None:
    for sent in (0x0CF013FE, 0x18F01317, 0x1CF01380):
        source, _ = source_of(tmp_path, EXTENDED | 0x0CF013FE)
        assert source.name_of(ins_frame(sent, 0)) == "PGN 61459"
        assert len(fly(source, sent)) > 40
    assert not fly(source_of(tmp_path, EXTENDED | 0x0CF013FE)[0], 0x18F01417)
    assert not fly(source_of(tmp_path, EXTENDED | 0x19F11223)[0], 0x19F11224)  # no J1939 by what the file says


def test_of_two_senders_one_is_used_until_one_is_chosen(tmp_path: Path) -> None:
    source, counters = source_of(tmp_path, EXTENDED | 0x0CF013FE)
    assert len(fly(source, 0x18F01317, 0x18F0132A)) > 40
    assert counters["frame_other_sender"] == 50
    assert "INS is sent by 0x17 and 0x2A: choose one with nav.dbc.source_address" in source.problems(NS + 100 * MS)
    source, counters = source_of(tmp_path, EXTENDED | 0x0CF013FE, sender=0x2A)
    assert len(fly(source, 0x18F01317, 0x18F0132A)) > 40
    assert not counters["frame_other_sender"]
    assert CanId(0x00F0132A, True, 0x03FFFFFF) in source.ids


def test_only_what_is_mapped_is_judged(tmp_path: Path) -> None:
    more = 'BO_ 2017 5: 8 X\nBO_ 7 STANDARD_OF_29_BITS: 8 X\nVAL_ 900 GONE 0 "x" ;\nnonsense\nBO_ 1 : 1 X\n'
    twice = 'BO_ 900 E: 2 INS\n SG_ A : 0|16@1+ (1,0) [0|0] "" X\n SG_ B : 8|16@1+ (1,0) [0|0] "" X\n'
    source, _ = source_of(tmp_path, 258, twice + more)
    assert len(source.ids) == 2
    settings = DbcSettings(file=tmp_path / "x.dbc", signals={"yaw": "E.A"})
    with pytest.raises(DbcError, match=r"nav\.dbc\.signals\.yaw: message E: The signal B does not fit in message E"):
        load_dbc_map(settings)
