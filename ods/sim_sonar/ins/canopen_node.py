"""What the simulated CANopen devices have in common: states, heartbeat, and their end of the bus."""

import threading
from collections import Counter, deque
from collections.abc import Iterator
from typing import Protocol

import can

from ods.base.clock import NS

NMT, HEARTBEAT = 0x000, 0x700
BOOT_UP, STOPPED, OPERATIONAL, PRE_OPERATIONAL = 0, 4, 5, 127
NMT_COMMANDS = {1: OPERATIONAL, 2: STOPPED, 128: PRE_OPERATIONAL, 129: BOOT_UP, 130: BOOT_UP}
SEND_TIMEOUT_S = 0.05
MOST_WAITING = 1000
"""Frames kept for a device that does not read."""


class CanEnd(Protocol):
    """What a device needs of a bus: python-can's, or a share of one."""

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next frame, None where there is none. Raises can.CanError."""

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame. Raises can.CanError."""


class SharedEnd:
    """One device's share of a bus end that several have; each receives all that comes, none what another one sends."""

    def __init__(self, bus: CanEnd, lock: threading.Lock, all_waiting: list[deque[can.Message]]) -> None:
        self._bus, self._lock, self._all_waiting = bus, lock, all_waiting
        self._waiting: deque[can.Message] = deque(maxlen=MOST_WAITING)
        all_waiting.append(self._waiting)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """Return the next frame, None where there is none; never waits. Raises can.CanError."""
        with self._lock:
            while (message := self._bus.recv(0)) is not None:
                for waiting in self._all_waiting:
                    waiting.append(message)
            return self._waiting.popleft() if self._waiting else None

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame. Raises can.CanError."""
        with self._lock:
            self._bus.send(msg, timeout=timeout)


def shared(bus: CanEnd, count: int) -> list[SharedEnd]:
    """Return shares of a bus end, for devices in any threads."""
    lock, all_waiting = threading.Lock(), list[deque[can.Message]]()
    return [SharedEnd(bus, lock, all_waiting) for _ in range(count)]


class CanopenNode:
    """A node that goes operational by itself and obeys NMT.

    Frames that the bus does not take are counted as `unsent` in `counters`, failures to read as `unread`.
    """

    def __init__(self, bus: CanEnd, node_id: int, heartbeat_period_s: float) -> None:
        self.counters: Counter[str] = Counter()
        self.state = BOOT_UP
        self.node_id = node_id
        self._bus = bus
        self._heartbeat_period_ns = round(heartbeat_period_s * NS)
        self._heartbeat_due_ns: int | None = None

    def receive(self) -> Iterator[can.Message]:
        """Read the bus empty: carry out NMT commands, yield what else comes."""
        try:
            while (message := self._bus.recv(0)) is not None:
                if message.arbitration_id != NMT or message.is_extended_id or len(message.data) != 2:
                    yield message
                elif message.data[1] in (0, self.node_id):
                    self.state = NMT_COMMANDS.get(message.data[0], self.state)
        except can.CanError:
            self.counters["unread"] += 1

    def boot(self) -> None:
        """Come up after power-on or a reset."""
        if self.state == BOOT_UP:
            self.transmit(HEARTBEAT + self.node_id, bytes([BOOT_UP]))
            self.state = OPERATIONAL
            self._heartbeat_due_ns = None

    def beat(self, t_ns: int) -> None:
        """Send the heartbeat, if it is due at that time of the node's own clock."""
        if self._heartbeat_due_ns is None or t_ns >= self._heartbeat_due_ns:
            self.transmit(HEARTBEAT + self.node_id, bytes([self.state]))
            self._heartbeat_due_ns = t_ns + self._heartbeat_period_ns

    def transmit(self, can_id: int, data: bytes) -> None:
        """Send a frame."""
        try:
            self._bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False), timeout=SEND_TIMEOUT_S)
        except can.CanError:
            self.counters["unsent"] += 1
