"""This process as a CANopen node: NMT slave, heartbeat producer, SDO server. Driven by its owner's loop, no threads."""

from collections import Counter
from typing import Any

import canopen

from ods import __version__
from ods.clock import NS
from ods.nav_bridge.can_frame import NMT, SDO_REQUEST, Frame
from ods.nav_bridge.pdo_layout import LayoutError, read_dictionary
from ods.nav_bridge.settings import CanopenSettings
from ods.nav_bridge.source import Send

NMT_BYTES, SDO_BYTES = 2, 8
HEARTBEAT_TIME = 0x1017
SOFTWARE_VERSION = 0x100A
STATISTICS = {1: "poses", 2: "epoch_torn", 3: "epoch_missing"}
"""Sub-indices of object 0x2000 and the counters behind them."""
STATISTICS_INDEX = 0x2000
MASK_32_BIT = 0xFFFFFFFF


class _PeriodicFrame:
    """A frame that `_LoopNetwork.tick` sends again and again; the interface is that of canopen's own task."""

    def __init__(self, can_id: int, data: bytes, period_s: float) -> None:
        self.can_id, self.data = can_id, data
        self.period_ns = round(period_s * NS)
        self.due_ns = 0
        self.stopped = False

    def update(self, data: bytes) -> None:
        self.data = bytes(data)

    def stop(self) -> None:
        self.stopped = True


class _LoopNetwork(canopen.Network):
    """canopen's network without its threads: frames leave through `send`, periodic ones when `tick` finds them due."""

    def __init__(self, send: Send) -> None:
        super().__init__()
        self._send = send
        self._periodic: list[_PeriodicFrame] = []

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        self._send(can_id, bytes(data))

    def send_periodic(self, can_id: int, data: bytes, period: float, remote: bool = False) -> Any:
        frame = _PeriodicFrame(can_id, bytes(data), period)
        self._periodic.append(frame)
        return frame

    def tick(self, now_ns: int) -> None:
        self._periodic = [frame for frame in self._periodic if not frame.stopped]
        for frame in self._periodic:
            if now_ns >= frame.due_ns:
                frame.due_ns = now_ns + frame.period_ns
                self._send(frame.can_id, frame.data)


class OwnNode:
    """The node that other devices see. Poses flow whatever NMT state it was sent to: the obstacle map needs them.

    Counts `node_frame_bad`: NMT and SDO frames that are malformed.
    """

    def __init__(self, settings: CanopenSettings, send: Send, counters: Counter[str]) -> None:
        self._counters = counters
        self._network = _LoopNetwork(send)
        self._node = canopen.LocalNode(settings.node_id, read_dictionary(settings.node_eds, settings.node_id))
        self._network[settings.node_id] = self._node
        self._node.add_read_callback(self._read)  # type: ignore[no-untyped-call]
        period_ms = round(settings.heartbeat_period_s * 1000.0)
        try:
            self._node.set_data(HEARTBEAT_TIME, 0, period_ms.to_bytes(2, "little"))
        except canopen.SdoAbortedError as error:
            raise LayoutError(f"{settings.node_eds}: object 0x{HEARTBEAT_TIME:X}: {error}") from error
        self._lengths = {NMT: NMT_BYTES, SDO_REQUEST + settings.node_id: SDO_BYTES}

    @property
    def ids(self) -> frozenset[int]:
        """Standard CAN identifiers that `take` wants."""
        return frozenset(self._lengths)

    @property
    def state(self) -> str:
        """NMT state by its CiA 301 name."""
        return str(self._node.nmt.state)

    def boot(self) -> None:
        """Announce the node and become operational by itself, as CiA 301 allows a self-starting device."""
        self._node.nmt.state = "INITIALISING"
        self._node.nmt.state = "PRE-OPERATIONAL"
        self._node.nmt.state = "OPERATIONAL"

    def take(self, frame: Frame) -> None:
        """Take an NMT command or SDO request."""
        wanted = self._lengths.get(frame.can_id)
        if wanted is None or frame.extended:
            return
        if len(frame.data) != wanted:
            self._counters["node_frame_bad"] += 1
            return
        try:
            self._network.notify(frame.can_id, bytearray(frame.data), 0.0)
        except Exception:  # canopen lets through whatever a request out of order runs into
            self._counters["node_frame_bad"] += 1

    def tick(self, now_ns: int) -> None:
        """Send what is due; carry out a reset that was commanded."""
        if self.state == "INITIALISING":
            self.boot()
        self._network.tick(now_ns)

    def start_remote(self, node_id: int) -> None:
        """Command `start remote node`."""
        self._network.send_message(NMT, bytes([1, node_id]))

    def _read(self, index: int, subindex: int, **_: Any) -> int | str | None:
        if index == STATISTICS_INDEX and subindex in STATISTICS:
            return self._counters[STATISTICS[subindex]] & MASK_32_BIT
        return __version__ if index == SOFTWARE_VERSION else None
