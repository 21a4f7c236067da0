"""The own CANopen node, with frames written and read as bytes (CiA 301)."""

import struct
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ods import __version__
from ods.clock import NS
from ods.nav_bridge.can_frame import Frame
from ods.nav_bridge.own_node import OwnNode
from ods.nav_bridge.pdo_layout import LayoutError
from ods.nav_bridge.settings import CanopenSettings

CONFIG = Path(__file__).parents[1] / "config"
REQUEST, ANSWER, HEARTBEAT = 0x620, 0x5A0, 0x720


class Bench:
    """A node and what it sent."""

    def __init__(self, eds: Path = CONFIG / "ods_node.eds") -> None:
        self.sent: list[tuple[int, bytes]] = []
        self.counters: Counter[str] = Counter()
        settings = CanopenSettings(ins_eds=CONFIG / "ins.eds", node_eds=eds, heartbeat_period_s=0.5)
        self.node = OwnNode(settings, lambda can_id, data: self.sent.append((can_id, data)), self.counters)
        self.node.boot()

    def take(self, can_id: int, data: bytes, extended: bool = False) -> list[tuple[int, bytes]]:
        """Hand a frame in and return what was sent in answer."""
        self.sent.clear()
        self.node.take(Frame(can_id, extended, data, 0))
        return list(self.sent)

    def upload(self, index: int, subindex: int) -> bytes:
        """Read an object of up to 4 bytes."""
        ((can_id, data),) = self.take(REQUEST, struct.pack("<BHB4x", 0x40, index, subindex))
        assert can_id == ANSWER
        assert data[0] & 0xE3 == 0x43
        assert data[1:4] == struct.pack("<HB", index, subindex)
        return data[4 : 8 - (data[0] >> 2 & 3)]


def test_it_boots_and_sends_its_heartbeat_at_the_configured_period() -> None:
    bench = Bench()
    assert bench.sent == [(HEARTBEAT, b"\x00")]
    bench.sent.clear()
    for tenth in range(51):
        bench.node.tick(10 * NS + tenth * NS // 10)
    assert bench.sent == [(HEARTBEAT, b"\x05")] * 11


def test_heartbeat_time_is_read_and_written_by_sdo() -> None:
    bench = Bench()
    assert bench.upload(0x1017, 0) == struct.pack("<H", 500)
    assert bench.take(REQUEST, bytes.fromhex("2b17100064000000")) == [(ANSWER, bytes.fromhex("6017100000000000"))]
    bench.sent.clear()
    for tenth in range(11):
        bench.node.tick(NS + tenth * NS // 10)
    assert bench.sent == [(HEARTBEAT, b"\x05")] * 11


def test_statistics_and_version_are_served() -> None:
    bench = Bench()
    bench.counters.update(poses=70_000, epoch_torn=3)
    assert bench.upload(0x2000, 1) == struct.pack("<I", 70_000)
    assert bench.upload(0x2000, 2) == struct.pack("<I", 3)
    ((_, answer),) = bench.take(REQUEST, bytes.fromhex("400a100000000000"))
    assert answer[:4] == bytes.fromhex("410a1000")  # segmented: more than 4 bytes
    ((_, segment),) = bench.take(REQUEST, bytes.fromhex("6000000000000000"))
    assert segment[1 : 1 + len(__version__)] == __version__.encode()


def test_an_unknown_object_is_refused_with_the_abort_code_for_it() -> None:
    ((can_id, data),) = Bench().take(REQUEST, struct.pack("<BHB4x", 0x40, 0x5555, 0))
    assert (can_id, data) == (ANSWER, struct.pack("<BHBI", 0x80, 0x5555, 0, 0x06020000))


def test_nmt_commands_change_its_state_and_a_reset_boots_it_again() -> None:
    bench = Bench()
    bench.node.tick(NS)
    for command, state in ((2, "STOPPED"), (128, "PRE-OPERATIONAL"), (1, "OPERATIONAL"), (2, "STOPPED")):
        bench.take(0x000, bytes([command, 0x20]))
        assert bench.node.state == state
    bench.take(0x000, bytes([1, 0x21]))
    assert bench.node.state == "STOPPED"
    bench.take(0x000, bytes([129, 0]))
    bench.node.tick(2 * NS)
    assert (HEARTBEAT, b"\x00") in bench.sent
    assert bench.node.state == "OPERATIONAL"


def test_it_starts_another_node_when_told() -> None:
    bench = Bench()
    bench.sent.clear()
    bench.node.start_remote(5)
    assert bench.sent == [(0x000, b"\x01\x05")]


@given(st.lists(st.tuples(st.sampled_from([0x000, REQUEST, 0x7E5, 0x185]), st.binary(max_size=8), st.booleans())))
def test_arbitrary_frames_do_no_harm(frames: list[tuple[int, bytes, bool]]) -> None:
    bench = Bench()
    for can_id, data, extended in frames:
        bench.take(can_id, data, extended)
    bench.take(0x000, b"\x01\x20")
    bench.node.tick(NS)
    assert bench.node.state == "OPERATIONAL"
    assert len(bench.upload(0x1018, 1)) == 4


def test_short_and_long_frames_and_requests_out_of_order_are_counted() -> None:
    bench = Bench()
    for can_id, data in (
        (0x000, b"\x01"),
        (0x000, b"\x02\x20\x00"),
        (REQUEST, b"\x40\x17\x10"),
        (REQUEST, bytes.fromhex("6000000000000000")),
    ):
        bench.take(can_id, data)
    assert bench.counters["node_frame_bad"] == 4
    assert bench.node.state == "OPERATIONAL"
    assert bench.take(REQUEST, struct.pack("<BHB4x", 0x40, 0x1017, 0), extended=True) == []


def test_an_eds_without_heartbeat_is_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "node.eds"
    file.write_text((CONFIG / "ods_node.eds").read_text().replace("[1017]", "[1016]"))
    with pytest.raises(LayoutError, match="object 0x1017"):
        Bench(file)
