"""Each fault of the CAN bus, by name: the real nav process on a real vcan says so while it lasts, and recovers in 2 s.

One process lives through all of them.
"""

import re
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import can
import psutil
import pytest
import zmq

from in_vcan import links
from ods.base import clock
from ods.sim_sonar.ins.canopen_ins import SimulatedIns
from tests.nav_bridge.nav_chain import CONFIG, EDS, MS, PERIOD_S, Client

RECOVERY_S = 2.0
"""From the end of the cause to the next pose."""
WATCH_S = 1.0
SPIN_PERCENT = 60.0
"""A process that waits properly takes a few per cent of a core, one that spins takes all of it."""
FLOOD_HZ = 8000
CONTROLLER_PROBLEM, BUS_OFF, RESTARTED = 0x004, 0x040, 0x100
"""Classes of error frames (Linux, can/error.h)."""
EMCY_RECOVERED = 0x8140
"""CiA 301: recovered from bus-off."""


class Ins(threading.Thread):
    """An INS at 100 Hz on `channel`; opens its own interface again when that breaks."""

    def __init__(self, channel: str, ahead_ns: int = 0) -> None:
        super().__init__(daemon=True)
        self.only: list[int] | None = None
        self.mute = False
        self._channel = channel
        self._ahead_ns = ahead_ns
        self._stopping = threading.Event()

    def run(self) -> None:
        while not self._stopping.is_set():
            with suppress(can.CanError, OSError), can.Bus(self._channel, "socketcan", ignore_config=True) as bus:
                self._send(SimulatedIns(bus, EDS))
            self._stopping.wait(0.05)

    def _send(self, ins: SimulatedIns) -> None:
        while not self._stopping.wait(PERIOD_S) and not ins.counters["unsent"]:
            if not self.mute:
                device_ns = (clock.utc_ns() + self._ahead_ns) // MS * MS
                ins.send(device_ns, (1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0), (1.5, 0.0, 0.0), only=self.only)

    def __enter__(self) -> "Ins":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopping.set()
        self.join()


class Rig:
    """The nav process, what it says, and the INS."""

    def __init__(self, client: Client, process: psutil.Process, ins: Ins) -> None:
        self.client, self.process, self.ins = client, process, ins

    def counter(self, name: str) -> int:
        """Return what a counter says in a health report that is made from now on."""
        old = self.client.health
        self.client.until(lambda: self.client.health is not old)
        assert self.client.health is not None
        return self.client.health.counters.get(name, 0)

    def counts(self, name: str, least: int) -> None:
        """Wait until a counter has come to `least`; a slow guest takes its time."""
        self.client.until(lambda: self.client.health is not None and self.client.health.counters[name] >= least)

    def flows(self) -> None:
        """Wait until new poses come; at most as long as a recovery may take."""
        begun_ns = clock.monotonic_ns()
        self.client.poses.clear()
        self.client.until(lambda: sum(pose.t_ns > begun_ns for pose in self.client.poses) > 3, RECOVERY_S)

    def is_well(self) -> None:
        """Wait until poses come and nothing is complained about any more."""
        self.flows()
        self.client.until(lambda: self.client.health is not None and not self.client.health.problems, RECOVERY_S + 1.0)

    def says(self, text: str) -> None:
        self.client.until(lambda: self.client.says(text), 5.0)

    def does_not_spin(self) -> None:
        """Watch what the process takes of a core while the fault lasts."""
        before_s, begun_s = self.cpu_s(), time.monotonic()
        time.sleep(WATCH_S)
        assert 100.0 * (self.cpu_s() - before_s) / (time.monotonic() - begun_s) < SPIN_PERCENT

    def cpu_s(self) -> float:
        """Return the processor time that the process has used."""
        times = self.process.cpu_times()
        return float(times.user + times.system)


@pytest.fixture(scope="module")
def running() -> Iterator[Rig]:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    with tempfile.TemporaryDirectory(prefix="ods-", dir="/dev/shm") as folder:  # a guest's files on disk are its host's
        client = Client(context, Path(folder))
        with nav(Path(folder), "vcan0") as process, Ins("vcan0") as ins:
            client.until(lambda: len(client.poses) > 20)
            yield Rig(client, process, ins)
        client.close()
    context.term()


@pytest.fixture
def rig(vcan0: str, running: Rig) -> Rig:
    running.is_well()
    return running


@contextmanager
def nav(run_dir: Path, channel: str) -> Iterator[psutil.Process]:
    text = (CONFIG / "onboard.toml").read_text(encoding="utf-8").replace("[bus]", f'[bus]\nrun_dir = "{run_dir}"')
    text = text.replace('channel = "can0"', f'channel = "{channel}"')
    for name in ("ins.eds", "ods_node.eds"):
        text = text.replace(f'"{name}"', f'"{CONFIG / name}"')
    config = run_dir / "onboard.toml"
    config.write_text(text, encoding="utf-8")
    process = subprocess.Popen([sys.executable, "-m", "ods", "nav", "--config", str(config)])
    try:
        yield psutil.Process(process.pid)
        assert process.poll() is None, "the nav process ended"
    finally:
        process.terminate()
        process.wait(10.0)


@contextmanager
def other_node(channel: str) -> Iterator[Callable[[int, bytes], None]]:
    """Yield what sends a standard frame."""
    with can.Bus(channel, "socketcan", ignore_config=True) as bus:
        yield lambda can_id, data: bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))


def test_link_down_and_up(rig: Rig, vcan0: str) -> None:
    links.down(vcan0)
    rig.says(f"{vcan0}: is down")
    rig.says("no pose for")
    rig.does_not_spin()
    links.up(vcan0)
    rig.is_well()


def test_interface_deleted_and_made_again(rig: Rig, vcan0: str) -> None:
    links.delete(vcan0)
    rig.says(f"{vcan0}: no such device")
    rig.says("no pose for")
    rig.does_not_spin()
    links.make(vcan0)
    rig.is_well()


def test_interface_replaced_at_once(rig: Rig, vcan0: str) -> None:
    links.delete(vcan0)
    links.make(vcan0)
    rig.is_well()


def test_silence(rig: Rig, vcan0: str) -> None:
    rig.ins.mute = True
    rig.says(f"s: {vcan0}: no CAN frame for")
    rig.says("no pose for")
    rig.does_not_spin()
    rig.ins.mute = False
    rig.is_well()


@pytest.mark.parametrize("can_id", [0x080, 0x7FF], ids=["frames that nav reads", "frames of others"])
def test_flood_of_8000_frames_a_second(rig: Rig, vcan0: str, can_id: int) -> None:
    before = rig.counter("sync")
    with other_node(vcan0) as send:
        sent, begun_s = 0, time.monotonic()
        rig.client.poses.clear()
        before_s = rig.cpu_s()
        while (elapsed_s := time.monotonic() - begun_s) < 2.0 * WATCH_S:
            for _ in range(max(0, round(FLOOD_HZ * elapsed_s) - sent)):
                with suppress(can.CanOperationError):  # the queue of vcan is full for a moment
                    send(can_id, b"")
                sent += 1
            time.sleep(0.005)
        used_percent = 100.0 * (rig.cpu_s() - before_s) / elapsed_s
    rig.client.until(lambda: len(rig.client.poses) > 100)  # those of the flood's time are there, too
    rig.is_well()
    if can_id == 0x080:
        rig.counts("sync", before + sent)
    else:
        assert used_percent < SPIN_PERCENT


def test_the_kernel_passes_on_what_nav_wants_and_nothing_else(rig: Rig) -> None:
    one_id = Path("/proc/net/can/rcvlist_fil").read_text()
    everything = Path("/proc/net/can/rcvlist_all").read_text()
    for can_id in (0x185, 0x705, 0x720):
        assert re.search(rf"vcan0\s+{can_id:x}\s+800007ff", one_id)  # standard identifiers only
    assert everything.count("vcan0") == 1  # the simulated INS


def test_a_process_that_was_stopped_for_a_while_has_lost_no_frame(rig: Rig, vcan0: str) -> None:
    before, sent = rig.counter("sync"), 3000
    rig.ins.mute = True
    with other_node(vcan0) as send:
        rig.process.suspend()
        for _ in range(sent):  # ten times what the buffer holds by default
            send(0x080, b"")
        rig.process.resume()
    rig.ins.mute = False
    rig.is_well()
    rig.counts("sync", before + sent)


def test_malformed_pdos_and_emergencies(rig: Rig, vcan0: str) -> None:
    before = {name: rig.counter(name) for name in ("emcy_bad", "pdo_short")}
    with other_node(vcan0) as send:
        for length in range(8):
            send(0x085, bytes(length))
            send(0x485, bytes(min(length, 6)))
    rig.is_well()
    assert {name: rig.counter(name) - count for name, count in before.items()} == {"emcy_bad": 8, "pdo_short": 8}
    assert all(abs(pose.position_ned[1] - 2.0) < 1e-9 for pose in rig.client.poses)


def test_two_nodes_with_the_id_of_the_ins(rig: Rig, vcan0: str) -> None:
    with Ins(vcan0, ahead_ns=7 * clock.NS):
        rig.says("two nodes send as node 5, the INS's id")
        rig.does_not_spin()
    rig.is_well()


def test_another_node_with_our_id(rig: Rig, vcan0: str) -> None:
    with other_node(vcan0) as send:
        for _ in range(10):
            send(0x720, b"\x05")
            time.sleep(0.1)
        rig.says("another node sends as node 32, our own id")
    rig.is_well()


def test_the_ins_stops_in_mid_epoch(rig: Rig) -> None:
    before = rig.counter("epoch_torn")
    rig.ins.only = [1, 2, 3]
    rig.says("no pose for")
    rig.does_not_spin()
    torn = rig.counter("epoch_torn") - before
    rig.ins.only = None
    rig.is_well()
    assert torn > 10


@pytest.mark.parametrize("ends_by", ["a restart", "a good frame"])
def test_bus_off(rig: Rig, vcan0: str, ends_by: str) -> None:
    """What a controller's driver tells, reported by another socket, as vcan has no controller."""
    names = ("can_error_frames", "can_bus_off", "can_recovered", "can_ignored")
    before = {name: rig.counter(name) for name in names}
    rig.ins.mute = True
    rig.says("no pose for")
    with can.Bus(vcan0, "socketcan", ignore_config=True) as controller:
        controller.send(error_frame(CONTROLLER_PROBLEM, 0x20))
        rig.says(f"{vcan0}: many errors on the bus (error-passive)")
        controller.send(error_frame(BUS_OFF))
        rig.says(f"{vcan0}: bus-off: wiring, termination or bit rate")
        rig.does_not_spin()
        if ends_by == "a restart":
            controller.send(error_frame(RESTARTED))
        else:
            rig.ins.mute = False
        rig.client.until(lambda: not rig.client.says("bus-off"), RECOVERY_S)
        assert EMCY_RECOVERED in emergencies(controller)
    rig.ins.mute = False
    rig.is_well()
    counted = {name: rig.counter(name) - count for name, count in before.items()}
    reported = 3 if ends_by == "a restart" else 2
    assert counted == {"can_error_frames": reported, "can_bus_off": 1, "can_recovered": 1, "can_ignored": 0}


def error_frame(classes: int, detail: int = 0) -> can.Message:
    """Return what a driver sends; `detail`: its second byte."""
    data = bytes([0, detail, 0, 0, 0, 0, 0, 0])
    return can.Message(arbitration_id=classes, is_error_frame=True, is_extended_id=False, data=data)


def emergencies(bus: can.BusABC) -> list[int]:
    """Return the codes that our node has sent since `bus` was opened, and sends within half a second."""
    codes, deadline_s = [], time.monotonic() + 0.5
    while (message := bus.recv(max(0.0, deadline_s - time.monotonic()))) is not None:
        if message.arbitration_id == 0x080 + 32 and len(message.data) == 8:
            codes.append(struct.unpack_from("<H", message.data)[0])
    return codes


def test_an_emergency_is_reported_and_taken_back(rig: Rig, vcan0: str) -> None:
    with other_node(vcan0) as send:
        send(0x085, struct.pack("<HB5x", 0x4310, 0x09))
        rig.says("INS error 0x4310 (temperature)")
        send(0x085, bytes(8))
    rig.is_well()


def test_an_extended_identifier_with_the_number_of_a_pdo_is_not_it(rig: Rig, vcan0: str) -> None:
    before = {name: rig.counter(name) for name in ("pdo_duplicate", "epoch_torn", "sequence_reset")}
    with can.Bus(vcan0, "socketcan", ignore_config=True) as bus:
        for _ in range(20):
            bus.send(can.Message(arbitration_id=0x485, data=bytes(7), is_extended_id=True))
    rig.is_well()
    assert {name: rig.counter(name) for name in before} == before
