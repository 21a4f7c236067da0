"""This process as a CANopen node: NMT slave, producer of heartbeat, EMCY and SYNC, SDO server. Without threads."""

from collections import Counter
from collections.abc import Set
from typing import Any

import canopen

from ods.base.clock import NS
from ods.nav_bridge.can.frame import EMCY, HEARTBEAT, NMT, SDO_ANSWER, SDO_REQUEST, SYNC, Frame
from ods.nav_bridge.canopen.eds import EdsError, read_dictionary
from ods.nav_bridge.canopen.ins_monitor import InsMonitor
from ods.nav_bridge.canopen.node.loop_network import LoopNetwork
from ods.nav_bridge.canopen.node.own_errors import Fault, NodeErrors
from ods.nav_bridge.canopen.node.own_objects import OwnObjects
from ods.nav_bridge.canopen.recent import DuplicateNode
from ods.nav_bridge.settings import CanopenSettings, NavSettings
from ods.nav_bridge.source import Send

NMT_BYTES, SDO_BYTES = 2, 8
NMT_COMMANDS = frozenset({1, 2, 128, 129, 130})
"""Those of CiA 301; canopen knows others, and would fall asleep."""
HEARTBEAT_TIME = 0x1017
OUT_OF_MEMORY = 0x05040005
MAX_DOWNLOAD = 64
"""Bytes; no object is longer, and canopen would collect segments for ever."""
COMMUNICATING = frozenset({"PRE-OPERATIONAL", "OPERATIONAL"})
"""NMT states with SDO, EMCY and SYNC."""


class OwnNode:
    """The node that other devices see. Poses flow whatever NMT state it was sent to: the obstacle map needs them.

    Counts `node_frame_bad` (NMT and SDO frames that are malformed) and `own_id_taken` (frames of another node with this
    node's id).
    """

    def __init__(
        self, nav: NavSettings, settings: CanopenSettings, send: Send, monitor: InsMonitor, counters: Counter[str]
    ) -> None:
        self.another = DuplicateNode("own_id_taken", counters, 1)
        """Evidence of another node with this node's id."""
        self._counters, self._monitor = counters, monitor
        self._send = send
        self._errors = NodeErrors(lambda data: send(EMCY + settings.node_id, data), round(settings.emcy_inhibit_s * NS))
        self._heartbeat_ms = round(settings.heartbeat_period_s * 1000.0)
        self._heartbeat_timeout_ns = monitor.timeout_ns
        self._sync_period_ns = round(settings.sync_period_s * NS)
        self._sync_due_ns = 0
        self._network = LoopNetwork(send)
        dictionary = read_dictionary(settings.node_eds, settings.node_id, "nav.canopen.node_eds")
        self._node = canopen.LocalNode(settings.node_id, dictionary)
        self._network[settings.node_id] = self._node
        objects = OwnObjects(nav, settings, monitor, self._errors, counters)
        self._node.add_read_callback(objects.read)  # type: ignore[no-untyped-call]
        self._node.add_write_callback(objects.write)  # type: ignore[no-untyped-call]
        try:
            self._power_on()
        except canopen.SdoAbortedError as error:
            raise EdsError(f"{settings.node_eds}: object 0x{HEARTBEAT_TIME:X}: {error}") from error
        self._lengths = {NMT: NMT_BYTES, SDO_REQUEST + settings.node_id: SDO_BYTES}
        self._own = frozenset(service + settings.node_id for service in (EMCY, SDO_ANSWER, HEARTBEAT))

    @property
    def ids(self) -> frozenset[int]:
        """Standard CAN identifiers that `take` wants."""
        return self._own | frozenset(self._lengths)

    @property
    def state(self) -> str:
        """NMT state by its CiA 301 name."""
        return str(self._node.nmt.state)

    def opened(self) -> None:
        """Take note that the bus is open: boot at the first time; an NMT state is kept when the bus comes back."""
        if self.state == "INITIALISING":
            self.boot()

    def boot(self) -> None:
        """Announce the node and become operational by itself, as CiA 301 allows a self-starting device."""
        self._node.nmt.state = "INITIALISING"
        self._node.nmt.state = "PRE-OPERATIONAL"
        self._node.nmt.state = "OPERATIONAL"

    def take(self, frame: Frame) -> None:
        """Take an NMT command, an SDO request, or what only another node with this node's id can have sent."""
        if frame.extended:
            return
        if frame.can_id in self._own:
            self.another.seen(frame.t_ns)
            return
        wanted = self._lengths.get(frame.can_id)
        if wanted is None or (frame.can_id != NMT and self.state not in COMMUNICATING):
            return
        if len(frame.data) != wanted or (frame.can_id == NMT and frame.data[0] not in NMT_COMMANDS):
            self._counters["node_frame_bad"] += 1
            return
        try:
            self._network.notify(frame.can_id, bytearray(frame.data), 0.0)
            self._bound_download()
        except Exception:  # canopen lets through whatever a request out of order runs into
            self._counters["node_frame_bad"] += 1

    def tick(self, now_ns: int, faults: Set[Fault]) -> None:
        """Send what is due; carry out a reset that was commanded."""
        if self.state == "INITIALISING":
            self._power_on()
            self.boot()
        self._network.tick(now_ns)
        communicating = self.state in COMMUNICATING
        self._errors.update(faults, now_ns, communicating)
        if communicating and self._sync_period_ns and now_ns >= self._sync_due_ns:
            on_time = now_ns - self._sync_due_ns < self._sync_period_ns
            self._sync_due_ns = (self._sync_due_ns if on_time else now_ns) + self._sync_period_ns
            self._send(SYNC, b"")
            self._monitor.sync(Frame(SYNC, extended=False, data=b"", t_ns=now_ns))

    def idle_ns(self, now_ns: int) -> int | None:
        """Return how long `tick` may wait, None when it need not be on time."""
        if not self._sync_period_ns or self.state not in COMMUNICATING:
            return None
        return max(0, self._sync_due_ns - now_ns)

    def start_remote(self, node_id: int) -> None:
        """Command `start remote node`."""
        self._network.send_message(NMT, bytes([1, node_id]))

    def _power_on(self) -> None:
        """Give writable objects the values that they have after a reset."""
        self._node.set_data(HEARTBEAT_TIME, 0, self._heartbeat_ms.to_bytes(2, "little"))
        self._monitor.timeout_ns = self._heartbeat_timeout_ns
        self._errors.history.clear()

    def _bound_download(self) -> None:
        server: Any = self._node.sdo
        if server._buffer and len(server._buffer) > MAX_DOWNLOAD:
            server._buffer.clear()
            server.abort(OUT_OF_MEMORY)
