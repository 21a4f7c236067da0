"""The simulated INS, byte by byte, and the slcan hub that stands in for a CAN bus, with python-can's own slcan."""

import math
import os
import struct
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import can
import pytest
from can.interfaces.slcan import slcanBus

from ods.base.frames.geometry import quat_from_euler
from ods.sim_sonar.ins.canopen_ins import SimulatedIns
from ods.sim_sonar.ins.sigmas import Sigmas
from ods.sim_sonar.ins.slcan_hub import SlcanHub, is_frame

EDS = Path(__file__).parents[2] / "config" / "ins.eds"
MS, NS = 1_000_000, 1_000_000_000
NOON_2024 = 1_704_110_400 * NS
DAYS_TO_2024 = 14_610  # from 1984-01-01: 40 years, 10 of them leap years
Sent = list[tuple[int, bytes]]


@pytest.fixture
def buses() -> Iterator[tuple[can.BusABC, can.BusABC]]:
    with ExitStack() as stack:
        made = [can.Bus("ins-test", "virtual", ignore_config=True) for _ in range(2)]
        for bus in made:
            stack.callback(bus.shutdown)
        yield made[0], made[1]


def drain(bus: can.BusABC) -> Sent:
    """Return everything that has arrived."""
    found = []
    while (message := bus.recv(0)) is not None:
        assert not message.is_extended_id
        found.append((message.arbitration_id, bytes(message.data)))
    return found


def test_an_epoch_is_these_bytes(buses: tuple[can.BusABC, can.BusABC]) -> None:
    ins = SimulatedIns(buses[0], EDS, node_id=5)
    attitude = quat_from_euler(-0.0523, 0.1047, -3.1)
    ins.send(
        NOON_2024 + 120 * MS,
        (12.345, -6.789, 4.2),
        attitude,
        (1.5, -0.02, 0.035),
        Sigmas((0.2, 0.25, 0.04), (0.003, 0.001, 0.0123)),
    )
    boot, alive, utc, sync, *pdos = drain(buses[1])
    noon_ms = 12 * 3600 * 1000 + 120
    assert boot == (0x705, b"\x00")
    assert alive == (0x705, b"\x05")
    assert utc == (0x100, struct.pack("<IH", noon_ms, DAYS_TO_2024))
    assert sync == (0x080, b"")
    assert pdos == [
        (0x185, struct.pack("<BBIH", 0, 15, noon_ms, DAYS_TO_2024)),
        (0x285, struct.pack("<ii", 12_345, -6_789)),
        (0x385, struct.pack("<iB", 4_200, 0)),
        (0x485, struct.pack("<hhhB", -523, 1_047, -31_000, 0)),
        (0x685, struct.pack("<hhhB", 1_500, -20, 35, 0)),
        (0x6A5, struct.pack("<HHBHB", 250, 40, 3, 123, 0)),
    ]


def test_sequence_heartbeat_and_time_go_on(buses: tuple[can.BusABC, can.BusABC]) -> None:
    ins = SimulatedIns(buses[0], EDS)
    for number in range(300):
        ins.send(NOON_2024 + number * 10 * MS, (0, 0, 0), (1, 0, 0, 0), (0, 0, 0))
    sent = drain(buses[1])
    assert [data[0] for can_id, data in sent if can_id == 0x185] == [number % 256 for number in range(300)]
    assert len([1 for can_id, _ in sent if can_id == 0x705]) == 1 + 15
    assert len([1 for can_id, _ in sent if can_id == 0x100]) == 3


def test_what_does_not_fit_is_sent_as_the_largest_count(buses: tuple[can.BusABC, can.BusABC]) -> None:
    ins = SimulatedIns(buses[0], EDS)
    ins.send(NOON_2024, (0, 0, 0), (1, 0, 0, 0), (99.0, 0, 0), Sigmas((1e6, 0, 0), (math.pi, 0, 0)))
    sent = dict(drain(buses[1]))
    assert struct.unpack_from("<h", sent[0x685])[0] == 32_767
    assert struct.unpack("<HHBHB", sent[0x6A5])[:3] == (65_535, 0, 255)


def test_it_obeys_nmt_commands_and_fails_on_request(buses: tuple[can.BusABC, can.BusABC]) -> None:
    ins, master = SimulatedIns(buses[0], EDS), buses[1]
    still = ((0, 0, 0), (1, 0, 0, 0), (0, 0, 0))
    ins.send(NOON_2024, *still)
    drain(master)
    master.send(can.Message(arbitration_id=0, data=b"\x80\x05", is_extended_id=False))
    ins.send(NOON_2024 + 300 * MS, *still)
    assert drain(master) == [(0x705, b"\x7f")]
    master.send(can.Message(arbitration_id=0, data=b"\x01\x00", is_extended_id=False))
    ins.send(NOON_2024 + 310 * MS, *still, only=(1, 2))
    assert [can_id for can_id, _ in drain(master)] == [0x080, 0x185, 0x285]
    ins.emergency(0x4310, 9, b"hot")
    ins.emergency(0)
    assert drain(master) == [(0x085, b"\x10\x43\x09hot\0\0"), (0x085, b"\0\0\1\0\0\0\0\0")]


def test_a_bus_that_is_gone_does_not_end_it(buses: tuple[can.BusABC, can.BusABC]) -> None:
    ins = SimulatedIns(buses[0], EDS)
    buses[0].shutdown()
    ins.send(NOON_2024, (0, 0, 0), (1, 0, 0, 0), (0, 0, 0))
    assert ins.counters == {"unread": 1, "unsent": 10}


@contextmanager
def slcan(*ports: Path) -> Iterator[list[slcanBus]]:
    """Open ports of the hub with python-can's own slcan."""
    with ExitStack() as stack:
        opened = []
        for port in ports:
            bus = slcanBus(str(port), sleep_after_open=0.0, timeout=0.01, bitrate=500_000)
            stack.callback(bus.shutdown)
            opened.append(bus)
        time.sleep(0.05)  # python-can does not wait for the adapter's answers
        yield opened


def collect(bus: can.BusABC, wanted: int) -> list[tuple[int, bool, bool, bytes]]:
    """Receive `wanted` frames."""
    found: list[tuple[int, bool, bool, bytes]] = []
    deadline_s = time.monotonic() + 10.0
    while len(found) < wanted and time.monotonic() < deadline_s:
        message = bus.recv(0.1)
        if message is not None:
            found.append((message.arbitration_id, message.is_extended_id, message.is_remote_frame, bytes(message.data)))
    return found


def test_a_busy_hub_loses_nothing_and_keeps_the_order(tmp_path: Path) -> None:
    with SlcanHub([tmp_path / "a", tmp_path / "b", tmp_path / "c"]) as hub, slcan(*hub.links) as (a, b, c):
        rounds, burst = 20, 64
        for _ in range(rounds):  # 1280 frames each way, in bursts
            for number in range(burst):
                a.send(can.Message(arbitration_id=0x185, data=struct.pack("<Q", number), is_extended_id=False))
                b.send(can.Message(arbitration_id=0x720, data=bytes([number]), is_extended_id=False))
            from_a = [(0x185, False, False, struct.pack("<Q", number)) for number in range(burst)]
            from_b = [(0x720, False, False, bytes([number])) for number in range(burst)]
            assert collect(b, burst) == from_a
            assert collect(a, burst) == from_b
            both = collect(c, 2 * burst)
            assert [frame for frame in both if frame[0] == 0x185] == from_a
            assert [frame for frame in both if frame[0] == 0x720] == from_b
        assert hub.counters["frames"] == rounds * burst * 2
        assert hub.counters["dropped"] == 0


def test_extended_and_remote_frames_pass(tmp_path: Path) -> None:
    with SlcanHub([tmp_path / "a", tmp_path / "b"]) as hub, slcan(*hub.links) as (a, b):
        a.send(can.Message(arbitration_id=0x185, data=b"\1\2", is_extended_id=True))
        a.send(can.Message(arbitration_id=0x705, is_remote_frame=True, is_extended_id=False))
        assert collect(b, 2) == [(0x185, True, False, b"\1\2"), (0x705, False, True, b"")]


def test_the_hub_answers_like_an_adapter_and_survives_garbage(tmp_path: Path) -> None:
    with SlcanHub([tmp_path / "a", tmp_path / "b"]) as hub, slcan(*hub.links) as (a, b):
        assert a.get_version(1.0) == (10, 13)
        assert a.get_serial_number(1.0) == "HUB0"
        raw = os.open(hub.links[0], os.O_RDWR | os.O_NOCTTY)
        for noise in (b"\xff\x00\r", b"t185\r", b"t1859\r", b"y" * 5000, b"\r", os.urandom(300) + b"\r"):
            os.write(raw, noise)
        a.send(can.Message(arbitration_id=0x123, data=b"\7", is_extended_id=False))
        assert collect(b, 1) == [(0x123, False, False, b"\7")]
        assert hub.counters["garbage"] >= 5
        os.close(raw)


def test_a_client_that_went_away_without_a_word_finds_no_old_frames_when_it_returns(tmp_path: Path) -> None:
    with SlcanHub([tmp_path / "a", tmp_path / "b"]) as hub, slcan(hub.links[0]) as (a,):
        lost = os.open(hub.links[1], os.O_RDWR | os.O_NOCTTY)
        os.write(lost, b"O\r")
        time.sleep(0.05)
        os.close(lost)  # as kill -9 does: no close command
        for number in range(6000):
            a.send(can.Message(arbitration_id=0x100, data=struct.pack("<Q", number), is_extended_id=False))
        dropped = -1
        while dropped != (dropped := hub.counters["dropped"]):  # the hub is still reading, what it reads is not old
            time.sleep(0.3)
        with slcan(hub.links[1]) as (back,):
            a.send(can.Message(arbitration_id=0x200, is_extended_id=False))
            assert collect(back, 1) == [(0x200, False, False, b"")]
        assert hub.counters["dropped"] > 0


def test_a_closed_port_neither_sends_nor_receives(tmp_path: Path) -> None:
    with SlcanHub([tmp_path / "a", tmp_path / "b"]) as hub, slcan(*hub.links) as (a, b):
        a.close()
        a.send(can.Message(arbitration_id=0x123, is_extended_id=False))
        b.send(can.Message(arbitration_id=0x124, is_extended_id=False))
        assert collect_briefly(a) == collect_briefly(b) == []
        assert hub.counters["refused"] == 1


def collect_briefly(bus: can.BusABC) -> list[can.Message]:
    """Return what arrives within 0.2 s."""
    found, deadline_s = [], time.monotonic() + 0.2
    while time.monotonic() < deadline_s:
        message = bus.recv(0.02)
        if message is not None:
            found.append(message)
    return found


def test_ports_can_be_unplugged_and_are_gone_after_close(tmp_path: Path) -> None:
    hub = SlcanHub([tmp_path / "sub" / "a", tmp_path / "b"])
    assert all(link.is_symlink() for link in hub.links)
    hub.unplug(0)
    assert not hub.links[0].exists()
    hub.plug(0)
    with slcan(*hub.links) as (a, b):
        a.send(can.Message(arbitration_id=0x1, is_extended_id=False))
        assert len(collect(b, 1)) == 1
    hub.close()
    hub.close()
    assert not any(link.is_symlink() for link in hub.links)


@pytest.mark.parametrize("line", [b"t0000", b"t1852a1B2", b"T1FFFFFFF0", b"r7FF8", b"R000001850"])
def test_lines_that_are_frames(line: bytes) -> None:
    assert is_frame(line)


@pytest.mark.parametrize(
    "line", [b"", b"t", b"t8000", b"t18529", b"t1852A1B2C", b"r7FF811", b"T200000000", b"t1 50", b"x"]
)
def test_lines_that_are_no_frames(line: bytes) -> None:
    assert not is_frame(line)
