"""The own CANopen node, with frames written and read as bytes (CiA 301)."""

import struct
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any, cast

import can
import canopen
import pytest
from hypothesis import given, settings, strategies as st

from ods import __version__
from ods.base.clock import NS
from ods.nav_bridge.can.frame import Frame
from ods.nav_bridge.canopen.eds import EdsError, read_dictionary
from ods.nav_bridge.canopen.ins_monitor import InsMonitor
from ods.nav_bridge.canopen.node.own_errors import Fault
from ods.nav_bridge.canopen.node.own_node import OwnNode
from ods.nav_bridge.settings import CanopenSettings, NavSettings

CONFIG = Path(__file__).parents[2] / "config"
NODE_EDS = CONFIG / "ods_node.eds"
REQUEST, ANSWER, HEARTBEAT, EMCY = 0x620, 0x5A0, 0x720, 0x0A0
MS = 1_000_000


class Bench:
    """A node and what it sent."""

    def __init__(self, eds: Path = NODE_EDS, **changes: Any) -> None:
        self.sent: list[tuple[int, bytes]] = []
        self.counters: Counter[str] = Counter()
        settings = CanopenSettings(ins_eds=CONFIG / "ins.eds", node_eds=eds, **changes)
        self.monitor = InsMonitor(settings.heartbeat_timeout_s, 0, self.counters)
        self.node = OwnNode(
            NavSettings(canopen=settings),
            settings,
            lambda can_id, data: self.sent.append((can_id, data)),
            self.monitor,
            self.counters,
        )
        self.node.boot()

    def take(self, can_id: int, data: bytes, extended: bool = False) -> list[tuple[int, bytes]]:
        """Hand a frame in and return what was sent in answer."""
        self.sent.clear()
        self.node.take(Frame(can_id, extended, data, 0))
        return list(self.sent)

    def tick(self, t_ns: int, *faults: Fault) -> list[tuple[int, bytes]]:
        """Tick and return what was sent, heartbeats aside."""
        self.sent.clear()
        self.node.tick(t_ns, set(faults))
        return [(can_id, data) for can_id, data in self.sent if can_id != HEARTBEAT]

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
        bench.node.tick(10 * NS + tenth * NS // 10, set())
    assert bench.sent == [(HEARTBEAT, b"\x05")] * 11


def test_heartbeat_time_is_read_and_written_by_sdo() -> None:
    bench = Bench()
    assert bench.upload(0x1017, 0) == struct.pack("<H", 500)
    assert bench.take(REQUEST, bytes.fromhex("2b17100064000000")) == [(ANSWER, bytes.fromhex("6017100000000000"))]
    bench.sent.clear()
    for tenth in range(11):
        bench.node.tick(NS + tenth * NS // 10, set())
    assert bench.sent == [(HEARTBEAT, b"\x05")] * 11


def test_an_unknown_object_is_refused_with_the_abort_code_for_it() -> None:
    ((can_id, data),) = Bench().take(REQUEST, struct.pack("<BHB4x", 0x40, 0x5555, 0))
    assert (can_id, data) == (ANSWER, struct.pack("<BHBI", 0x80, 0x5555, 0, 0x06020000))


def test_nmt_commands_change_its_state_and_a_reset_boots_it_again() -> None:
    bench = Bench()
    bench.node.tick(NS, set())
    for command, state in ((2, "STOPPED"), (128, "PRE-OPERATIONAL"), (1, "OPERATIONAL"), (2, "STOPPED")):
        bench.take(0x000, bytes([command, 0x20]))
        assert bench.node.state == state
    bench.take(0x000, bytes([1, 0x21]))
    assert bench.node.state == "STOPPED"
    bench.take(0x000, bytes([129, 0]))
    bench.node.tick(2 * NS, set())
    assert (HEARTBEAT, b"\x00") in bench.sent
    assert bench.node.state == "OPERATIONAL"


def test_it_starts_another_node_when_reported() -> None:
    bench = Bench()
    bench.sent.clear()
    bench.node.start_remote(5)
    assert bench.sent == [(0x000, b"\x01\x05")]


@settings(max_examples=40)
@given(st.lists(st.tuples(st.sampled_from([0x000, REQUEST, 0x7E5, 0x185]), st.binary(max_size=8), st.booleans())))
def test_arbitrary_frames_do_no_harm(frames: list[tuple[int, bytes, bool]]) -> None:
    bench = Bench()
    for can_id, data, extended in frames:
        bench.take(can_id, data, extended)
    bench.take(0x000, b"\x01\x20")
    bench.node.tick(NS, set())
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
    file.write_text((CONFIG / "ods_node.eds").read_text().replace("[1017]", "[1019]"))
    with pytest.raises(EdsError, match="object 0x1017"):
        Bench(file)


@pytest.fixture
def client() -> Iterator[tuple[Bench, canopen.RemoteNode]]:
    """A node on a virtual bus, served by a thread, and canopen's own SDO client at the other end."""
    bench = Bench(serial_number=4711, ins_node_id=9, sync_period_s=0.02)
    stopping = threading.Event()
    with ExitStack() as stack:
        near = stack.enter_context(can.Bus("node-test", "virtual", ignore_config=True))
        network = canopen.Network()
        network.connect(channel="node-test", interface="virtual", ignore_config=True)
        stack.callback(network.disconnect)

        def serve() -> None:
            while not stopping.is_set():
                message = near.recv(0.02)
                if message is not None:
                    for can_id, data in bench.take(message.arbitration_id, bytes(message.data)):
                        near.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        stack.callback(thread.join)
        stack.callback(stopping.set)
        yield bench, network.add_node(32, str(NODE_EDS))


def test_every_object_of_the_eds_is_read_by_an_sdo_client(client: tuple[Bench, canopen.RemoteNode]) -> None:
    bench, remote = client
    bench.counters.update(poses=70_000, pdo_short=3)
    bench.tick(NS, *Fault)
    reported: dict[tuple[int, int], Any] = {}
    for entry in remote.object_dictionary.values():
        for variable in [entry] if isinstance(entry, canopen.objectdictionary.ODVariable) else entry.values():
            where = (variable.index, variable.subindex)
            if where[0] == 0x1003 and where[1] > len(Fault):
                with pytest.raises(canopen.SdoAbortedError, match="0x08000024"):
                    remote.sdo.upload(*where)
            else:
                reported[where] = variable.decode_raw(remote.sdo.upload(*where))
    assert reported[0x1000, 0] == reported[0x1018, 1] == 0
    assert reported[0x1001, 0] == 0x91
    assert reported[0x1003, 0] == len(Fault)
    codes = {reported[0x1003, sub] for sub in range(1, 1 + len(Fault))}
    assert codes == {0x8100, 0x8130, 0x8140, 0x8210, 0xFF01, 0xFF02, 0xFF03}
    assert (reported[0x1005, 0], reported[0x1006, 0]) == (0x40000080, 20_000)
    assert reported[0x1008, 0] == "ODS navigation bridge"
    assert reported[0x100A, 0] == __version__
    assert reported[0x1014, 0] == EMCY
    assert reported[0x1016, 1] == 9 << 16 | 1000
    assert reported[0x1018, 4] == 4711
    assert (reported[0x1200, 1], reported[0x1200, 2]) == (REQUEST, ANSWER)
    counted: Any = remote.object_dictionary[0x2000]
    names = {counted[sub].name: reported[0x2000, sub] for sub in range(1, reported[0x2000, 0] + 1)}
    assert {name: count for name, count in names.items() if count} == {"poses": 70_000, "pdo_short": 3, "sync": 1}
    assert [reported[0x2001, sub] for sub in range(1, 6)] == [9, 500, 100, 1000, 0]
    assert len(reported) > 60


def test_the_eds_lists_each_object_once() -> None:
    text = NODE_EDS.read_text()
    dictionary: Any = read_dictionary(NODE_EDS, 32, "nav.canopen.node_eds")
    listed = [int(line.split("=")[1], 16) for line in text.splitlines() if line.partition("=")[0].isdigit()]
    assert sorted(listed) == sorted(dictionary)
    for entry in dictionary.values():
        if not isinstance(entry, canopen.objectdictionary.ODVariable):
            assert f"[{entry.index:X}]\nParameterName={entry.name}\n" in text
            assert f"SubNumber={len(entry)}\n" in text.split(f"[{entry.index:X}]")[1][:120]
            assert list(entry) == list(range(len(entry)))


def test_what_may_be_written_is_and_what_may_not_is_refused() -> None:
    bench = Bench()
    bench.tick(NS, Fault.NO_POSE)

    def download(index: int, sub: int, value: int, size: int) -> bytes:
        command = 0x23 | (4 - size) << 2
        ((_, answer),) = bench.take(REQUEST, struct.pack("<BHBI", command, index, sub, value))
        return answer[:1] if answer[0] == 0x60 else answer[4:]

    assert download(0x1016, 1, 5 << 16 | 2500, 4) == b"\x60"
    assert bench.monitor.timeout_ns == 2_500 * MS
    assert bench.upload(0x1016, 1) == struct.pack("<HH", 2500, 5)
    assert download(0x1016, 1, 6 << 16 | 2500, 4) == struct.pack("<I", 0x06090030)
    assert download(0x1003, 0, 1, 1) == struct.pack("<I", 0x06090030)
    assert bench.upload(0x1003, 0) == b"\x01"
    assert download(0x1003, 0, 0, 1) == b"\x60"
    assert bench.upload(0x1003, 0) == b"\x00"
    assert download(0x1016, 1, 5, 2) == struct.pack("<I", 0x06070010)
    assert download(0x1014, 0, 1, 4) == struct.pack("<I", 0x06010002)
    bench.take(0x000, b"\x81\x20")
    bench.tick(2 * NS)
    assert bench.monitor.timeout_ns == NS


def test_a_download_without_end_is_aborted() -> None:
    bench = Bench()
    bench.take(REQUEST, struct.pack("<BHB4x", 0x20, 0x1017, 0))
    answers = [bench.take(REQUEST, bytes([0x10 * (step % 2)]) + bytes(7)) for step in range(300)]
    aborted = [(can_id, data) for answer in answers for can_id, data in answer if data[0] == 0x80]
    assert len(aborted) > 20
    assert aborted[0][1][4:] == struct.pack("<I", 0x05040005)


def test_in_stopped_there_is_neither_sdo_nor_emcy_nor_sync_but_a_heartbeat() -> None:
    bench = Bench(sync_period_s=0.01)
    bench.take(0x000, b"\x02\x20")
    assert bench.take(REQUEST, struct.pack("<BHB4x", 0x40, 0x1017, 0)) == []
    assert bench.tick(NS, Fault.NO_POSE) == []
    assert bench.sent == [(HEARTBEAT, b"\x04")]
    assert bench.node.idle_ns(NS) is None
    bench.take(0x000, b"\x80\x20")
    assert len(bench.take(REQUEST, struct.pack("<BHB4x", 0x40, 0x1017, 0))) == 1
    sent = bench.tick(2 * NS, Fault.NO_POSE)
    assert sent == [(EMCY, bytes.fromhex("01ff810000000000")), (0x080, b"")]


@pytest.mark.parametrize("command", [0, 80, 96, 255])
def test_nmt_commands_that_cia_301_does_not_know_change_nothing(command: int) -> None:
    bench = Bench()
    bench.take(0x000, bytes([command, 0]))
    assert bench.node.state == "OPERATIONAL"
    assert bench.counters["node_frame_bad"] == 1


def test_faults_are_reported_one_by_one_and_their_end_once() -> None:
    bench = Bench(emcy_inhibit_s=0.1)
    two = (Fault.HEARTBEAT_LOST, Fault.NO_POSE)
    assert bench.tick(NS) == []
    assert bench.tick(NS + 1, *two) == [(EMCY, bytes.fromhex("3081910000000000"))]
    assert bench.upload(0x1001, 0) == b"\x91"
    assert bench.tick(NS + 50 * MS, *two) == []
    assert bench.tick(NS + 101 * MS, *two) == [(EMCY, bytes.fromhex("01ff910000000000"))]
    assert bench.tick(2 * NS, *two) == []
    assert bench.tick(3 * NS, Fault.NO_POSE) == []  # not all is well: code 0 would say so
    assert bench.tick(4 * NS, *two) == [(EMCY, bytes.fromhex("3081910000000000"))]
    assert bench.tick(4 * NS + 1) == []
    assert bench.tick(5 * NS) == [(EMCY, bytes(8))]
    assert bench.tick(6 * NS) == []
    assert bench.upload(0x1001, 0) == b"\x00"
    assert bench.upload(0x1003, 0) == b"\x03"
    assert bench.upload(0x1003, 1) == struct.pack("<I", 0x8130)


def test_our_emergencies_are_what_canopen_takes_for_emergencies() -> None:
    bench = Bench()
    consumer: Any = cast(Any, canopen.emcy.EmcyConsumer)()
    for step, faults in enumerate([(Fault.OWN_ID_TAKEN,), ()]):
        for can_id, data in bench.tick((step + 1) * NS, *faults):
            consumer.on_emcy(can_id, data, 0.0)
    assert [(entry.code, entry.register) for entry in consumer.log] == [(0xFF03, 0x81), (0, 0)]
    assert consumer.active == []


def test_sync_is_sent_at_its_period() -> None:
    bench = Bench(sync_period_s=0.01)
    times = [t_ns for t_ns in range(NS, 2 * NS, MS // 2) if bench.tick(t_ns + t_ns // 7 % 300_000)]
    assert len(times) == 100
    assert bench.monitor.sync_ns is not None
    assert bench.counters["sync"] == 100
    bench.tick(5 * NS)  # after a pause it does not catch up
    assert bench.tick(5 * NS + 5 * MS) == []
    assert bench.node.idle_ns(5 * NS + 5 * MS) == 5 * MS


def test_a_wrong_part_of_the_status_is_named() -> None:
    with pytest.raises(ValueError, match="status_bits: 'pos' is not one of position, attitude"):
        Bench(status_bits={"pos": 1})


@pytest.mark.parametrize("can_id", [HEARTBEAT, ANSWER, EMCY])
def test_two_nodes_with_our_id_are_noticed(can_id: int) -> None:
    bench = Bench()
    assert not bench.node.another.now(NS)
    assert can_id in bench.node.ids
    bench.node.take(Frame(can_id, False, b"\x05", 10 * NS))
    assert bench.node.another.now(11 * NS)
    assert not bench.node.another.now(12 * NS)
    assert bench.counters["own_id_taken"] == 1
