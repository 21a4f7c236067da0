"""The CAN interface: python-can's `virtual` bus, an slcan adapter on a pty, and settings."""

import contextlib
import os
import time
import tty
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import can
import pytest
from hypothesis import given, strategies as st

from ods.base import clock
from ods.base.errors import OdsError
from ods.base.settings_file import ConfigError, load
from ods.nav_bridge.can.frame import CanId, Frame
from ods.nav_bridge.can.link import CanLink
from ods.nav_bridge.can.slcan_bus import SlcanBus, parse
from ods.nav_bridge.settings import CanSettings, NavSettings
from ods.sim_sonar.ins.slcan_hub import SlcanHub

CANOPEN = "[canopen]\nins_eds = 'ins.eds'\nnode_eds = 'node.eds'"


class Owner:
    """A link and what it reported its owner."""

    def __init__(self, **options: str | int | float) -> None:
        self.counters: Counter[str] = Counter()
        self.fds: list[int | None] = []
        config = CanSettings(**options)  # type: ignore[arg-type]
        self.link = CanLink(config, [CanId(0x185, extended=False)], self.counters, self.fds.append, self.fds.remove)

    def read(self) -> list[Frame]:
        return list(self.link.read(clock.monotonic_ns()))

    def until(self, wanted: str, patience_s: float = 5.0) -> None:
        """Tick until the counter `wanted` has risen."""
        before, deadline_s = self.counters[wanted], time.monotonic() + patience_s
        while self.counters[wanted] == before and time.monotonic() < deadline_s:
            self.link.tick()
            self.read()
            time.sleep(0.01)
        assert self.counters[wanted] > before


@pytest.fixture
def other() -> Iterator[can.BusABC]:
    bus = can.Bus("nav-link", "virtual", ignore_config=True)
    yield bus
    bus.shutdown()


def test_data_frames_come_through_and_others_are_counted(other: can.BusABC) -> None:
    owner = Owner(interface="virtual", channel="nav-link")
    owner.link.tick()
    assert owner.link.is_open
    assert owner.fds == [None]
    for flags in ({}, {"is_remote_frame": True}, {"is_fd": True}, {"is_extended_id": True}):
        other.send(
            can.Message(
                arbitration_id=0x185,
                data=b"" if "is_remote_frame" in flags else b"\1",
                **{"is_extended_id": False} | flags,
            )
        )
    before_ns = clock.monotonic_ns()
    plain, extended = owner.read()
    assert (plain.can_id, plain.extended, plain.data) == (0x185, False, b"\1")
    assert extended.extended
    assert plain.t_ns <= before_ns
    assert owner.counters["can_ignored"] == 2
    owner.link.send(0x720, b"\5")
    received = other.recv(1.0)
    assert received is not None
    assert (received.arbitration_id, received.is_extended_id, bytes(received.data)) == (0x720, False, b"\5")
    owner.link.close()
    assert owner.fds == []


def error_frame(classes: int, details: str = "") -> can.Message:
    """Return what a driver tells, the details in hexadecimal."""
    data = bytes.fromhex(details).ljust(8, b"\0")
    return can.Message(arbitration_id=classes, data=data, is_error_frame=True, is_extended_id=False)


GOOD_FRAME = can.Message(arbitration_id=0x185, is_extended_id=False)


@pytest.mark.parametrize("end", [error_frame(0x100), GOOD_FRAME], ids=["restarted", "a good frame"])
def test_bus_off_is_reported_until_it_ends(other: can.BusABC, end: can.Message) -> None:
    owner = Owner(interface="virtual", channel="nav-link")
    owner.link.tick()
    for message in (error_frame(0x04, "00 20"), error_frame(0x44, "00 20"), error_frame(0x40)):
        other.send(message)
    assert owner.read() == []
    owner.link.close()
    assert "nav-link: bus-off: wiring, termination or bit rate" in owner.link.problems()
    owner.link.tick()
    assert owner.link.problems() == ["nav-link: bus-off: wiring, termination or bit rate"]
    other.send(end)
    owner.read()
    assert owner.link.problems() == []
    names = ("can_error_frames", "can_bus_off", "can_recovered")
    assert [owner.counters[name] for name in names] == [3 + end.is_error_frame, 1, 1]
    owner.link.close()


def test_error_passive_and_loneliness_are_reported_while_they_last(
    other: can.BusABC, monkeypatch: pytest.MonkeyPatch
) -> None:
    owner = Owner(interface="virtual", channel="nav-link", silence_s=1000.0)
    owner.link.tick()
    passive = "nav-link: many errors on the bus (error-passive): wiring, termination or bit rate"
    said = []
    for details in ("00 01", "00 10", "00 01", "00 08", "00 20", "00 40"):  # 01: overflow, which is another matter
        other.send(error_frame(0x04, details))
        other.send(GOOD_FRAME)
        owner.read()
        said.append(owner.link.problems())
    assert said == [[], [passive], [passive], [], [passive], []]
    other.send(error_frame(0x20))
    owner.read()
    assert owner.link.problems() == [
        "nav-link: no node acknowledges: there is no other node on the bus, or it has another bit rate"
    ]
    monkeypatch.setattr(clock, "monotonic_ns", lambda: time.monotonic_ns() + 2 * clock.NS)
    assert owner.link.problems() == []
    owner.link.close()


def test_error_frames_do_not_break_the_silence(other: can.BusABC) -> None:
    owner = Owner(interface="virtual", channel="nav-link", silence_s=0.2)
    owner.link.tick()
    deadline_s = time.monotonic() + 5.0
    while not owner.counters["can_silent"] and time.monotonic() < deadline_s:
        other.send(error_frame(0x80))
        owner.read()
        owner.link.tick()
        time.sleep(0.01)
    assert owner.counters["can_silent"] == 1
    owner.link.close()


def test_a_step_of_the_wall_clock_does_not_move_arrivals(other: can.BusABC, monkeypatch: pytest.MonkeyPatch) -> None:
    owner = Owner(interface="virtual", channel="nav-link")
    owner.link.tick()
    for step_ns in (0, 100 * clock.NS, -100 * clock.NS):
        other.send(can.Message(arbitration_id=0x185, is_extended_id=False))
        stepped = SimpleNamespace(
            time_ns=lambda step=step_ns: time.clock_gettime_ns(time.CLOCK_REALTIME) + step,
            monotonic_ns=time.monotonic_ns,
        )
        monkeypatch.setattr(clock, "time", stepped)
        (frame,) = owner.read()
        assert 0 <= time.monotonic_ns() - frame.t_ns < 500_000_000
    owner.link.close()


def test_a_silent_interface_is_opened_again(other: can.BusABC) -> None:
    owner = Owner(interface="virtual", channel="nav-link", silence_s=0.05)
    owner.until("can_silent")
    assert owner.link.is_open
    assert owner.counters["can_opened"] == 2
    assert "nav-link: no CAN frame for" in owner.link.problems()[0]
    other.send(can.Message(arbitration_id=0x185, is_extended_id=False))
    assert len(owner.read()) == 1
    assert owner.link.problems() == []
    owner.link.close()


def test_a_missing_device_is_reported_and_opened_when_it_comes(tmp_path: Path) -> None:
    port = tmp_path / "can0"
    owner = Owner(interface="slcan", channel=str(port), bitrate=500_000)
    owner.link.tick()
    assert not owner.link.is_open
    assert owner.link.problems() == [f"{port}: no such file or directory"]
    with SlcanHub([port, tmp_path / "can1"]) as hub:
        owner.until("can_opened")
        assert len(owner.fds) == 1
        hub.unplug(0)
        owner.until("can_lost")
        assert not owner.link.is_open
        assert owner.fds == []
        hub.plug(0)
        owner.until("can_opened")
        owner.link.close()


def test_no_such_network_interface() -> None:
    owner = Owner(interface="socketcan", channel="odsnone0")
    owner.link.tick()
    (problem,) = owner.link.problems()
    assert problem.startswith("odsnone0: ")
    assert "\n" not in problem
    owner.link.send(0x720, b"")
    assert owner.read() == []


def test_settings_that_can_never_work_end_the_process(tmp_path: Path) -> None:
    port = tmp_path / "can0"
    with SlcanHub([port]), pytest.raises(OdsError, match="bitrate") as error:
        Owner(channel=str(port), interface="slcan", bitrate=123).link.tick()
    assert str(error.value).startswith("nav.can: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[can]\ninterface = 'udp_multicast'", "can.interface: udp_multicast is not allowed"),
        ("[can]\nchannel = ''", "can.channel: must not be empty"),
        ("[canopen]\nnode_id = 5", "canopen.node_id: 5 is the INS's own"),
        ("[canopen]\nnode_id = 128", "canopen.node_id"),
        ("[can]\nbaud = 5", "can.baud: unknown key"),
        ("source = 'dbc2'", "source"),
    ],
)
def test_wrong_settings_are_one_line_with_the_key(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "nav.toml"
    file.write_text(text.replace("[canopen]", CANOPEN) if "[canopen]" in text else text + "\n" + CANOPEN)
    with pytest.raises(ConfigError) as error:
        load(file, NavSettings)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_settings_with_more_options_for_python_can(tmp_path: Path) -> None:
    file = tmp_path / "nav.toml"
    file.write_text(CANOPEN + "\n[can]\ninterface = 'slcan'\noptions = {tty_baudrate = 921600}")
    nav = load(file, NavSettings)
    assert nav.canopen is not None
    assert nav.canopen.ins_eds == tmp_path / "ins.eds"
    assert nav.can.options == {"tty_baudrate": 921600}


@pytest.mark.parametrize(
    ("line", "can_id", "extended", "data"),
    [
        (b"t1852A1b2", 0x185, False, b"\xa1\xb2"),
        (b"t0800", 0x080, False, b""),
        (b"T000001853010203", 0x185, True, b"\1\2\3"),
        (b"r1854", 0x185, False, b""),
        (b"R1FFFFFFF0", 0x1FFFFFFF, True, b""),
        (b"t1851FF1234", 0x185, False, b"\xff"),  # with a time stamp
    ],
)
def test_slcan_lines(line: bytes, can_id: int, extended: bool, data: bytes) -> None:
    assert parse(line, 7) == Frame(can_id, extended, data, 7)


@pytest.mark.parametrize(
    "line", [b"", b"z", b"t", b"t185", b"t1859", b"t1852A1", b"t8000", b"T0000018", b"t1851G0", b"\xff\xfe"]
)
def test_lines_that_are_no_frames(line: bytes) -> None:
    assert parse(line, 0) is None


@given(st.binary(max_size=40))
def test_arbitrary_lines_do_no_harm(line: bytes) -> None:
    frame = parse(line, 0)
    assert frame is None or len(frame.data) <= 8


def receive(bus: SlcanBus, wanted: int) -> list[tuple[bool, bytes]]:
    """Return what arrives, until `wanted` frames have."""
    found: list[tuple[bool, bytes]] = []
    deadline_s = time.monotonic() + 5.0
    while len(found) < wanted and time.monotonic() < deadline_s:
        found += [(frame.extended, frame.data) for frame in bus.receive(512, 0)]
    return found


def test_a_burst_is_read_whole_and_garbage_is_dropped_line_by_line() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    counters: Counter[str] = Counter()
    bus = SlcanBus(os.ttyname(slave), counters)
    os.write(master, b"z\rt18511\rr1850\r\xff\xfe\rt185111\r\a\aT000001850\rV1013\r" + b"x" * 200 + b"\rt185122\rt1851")
    assert receive(bus, 3) == [(False, b"\x11"), (True, b""), (False, b"\x22")]
    assert (counters["can_garbage"], counters["can_ignored"]) == (3, 1)
    os.write(master, b"33\r")
    assert receive(bus, 1) == [(False, b"\x33")]
    bus.shutdown()
    os.close(slave)
    os.close(master)


def test_an_adapter_that_takes_no_bytes_holds_nobody_up() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(slave, False)
    with contextlib.suppress(BlockingIOError):
        while True:
            os.write(slave, bytes(1024))  # until the line is full
    owner = Owner(interface="slcan", channel=os.ttyname(slave), bitrate=500_000)
    owner.link.tick()
    assert not owner.link.is_open
    assert "write" in owner.link.problems()[0].lower()
    os.close(slave)
    os.close(master)


def test_an_adapter_that_is_gone_reads_as_an_error_not_as_silence() -> None:
    master, slave = os.openpty()
    tty.setraw(slave)
    bus = SlcanBus(os.ttyname(slave), Counter())
    os.close(slave)
    os.close(master)
    with pytest.raises(can.CanOperationError):
        receive(bus, 1)
    with contextlib.suppress(can.CanOperationError):
        bus.shutdown()
    bus.serialPortOrig.close()
