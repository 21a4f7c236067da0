"""This node's own errors: the emergency messages it sends, its error register and its error history (CiA 301)."""

from collections.abc import Callable, Set
from enum import IntEnum

from ods.nav_bridge.can.frame import EMCY_FRAME

GENERIC, COMMUNICATION, MANUFACTURER = 0x01, 0x10, 0x80
"""Bits of the error register."""
HISTORY_LENGTH = 8
NO_ERROR = 0


class Fault(IntEnum):
    """What may be wrong, by its CiA 301 error code; from 0xFF00 the codes are our own."""

    BUS_LOST = 0x8100
    """The CAN interface failed and was opened again; no pose since."""
    HEARTBEAT_LOST = 0x8130
    """The INS's heartbeat."""
    BUS_OFF_OVER = 0x8140
    """The CAN controller recovered from bus-off, within the last second."""
    PDO_SHORT = 0x8210
    """A PDO of the INS was shorter than its mapping, within the last second."""
    NO_POSE = 0xFF01
    """For longer than `nav.stale_s`, with the bus open."""
    INS_TWICE = 0xFF02
    """Two nodes send as the INS."""
    OWN_ID_TAKEN = 0xFF03
    """Another node sends with this node's id."""


class NodeErrors:
    """Reports every fault once when it comes, and code 0 when all are over. Messages are `inhibit_ns` apart at
    least."""

    def __init__(self, send: Callable[[bytes], None], inhibit_ns: int) -> None:
        self.history: list[int] = []
        """Codes of the newest faults, newest first."""
        self._send = send
        self._inhibit_ns = inhibit_ns
        self._due_ns = 0
        self._active: Set[Fault] = frozenset()
        self._sent: Set[Fault] = frozenset()
        self._in_error = False

    @property
    def register(self) -> int:
        """Return the error register."""
        bits = 0
        for fault in self._active:
            bits |= GENERIC | (COMMUNICATION if fault >> 12 == 8 else MANUFACTURER)
        return bits

    def update(self, active: Set[Fault], now_ns: int, may_send: bool) -> None:
        """Take the faults there are now; send one message if one is due. One not sent yet is not forgotten."""
        self.history = [*sorted(active - self._active, reverse=True), *self.history][:HISTORY_LENGTH]
        self._active = frozenset(active)
        self._sent &= self._active
        if not may_send or now_ns < self._due_ns:
            return
        new = sorted(self._active - self._sent)
        if new:
            self._sent |= {new[0]}
        elif self._active or not self._in_error:
            return
        self._in_error = bool(self._active)
        self._due_ns = now_ns + self._inhibit_ns
        self._send(EMCY_FRAME.pack(new[0] if new else NO_ERROR, self.register))
