"""A CANopen navigation system: its PDOs, what else it says, and our own node beside it."""

from collections.abc import Callable, Set

from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.messages import Pose
from ods.nav_bridge.can.frame import EMCY, HEARTBEAT, SYNC, TIME, CanId, Frame
from ods.nav_bridge.can.source import CanSource
from ods.nav_bridge.canopen.eds import EdsError
from ods.nav_bridge.canopen.epoch import Epoch, EpochAssembler
from ods.nav_bridge.canopen.ins_monitor import BOOT_UP, PRE_OPERATIONAL, InsMonitor
from ods.nav_bridge.canopen.node.own_errors import Fault
from ods.nav_bridge.canopen.node.own_node import OwnNode
from ods.nav_bridge.canopen.object_map import object_map
from ods.nav_bridge.canopen.pdo_layout import load_pdo_set
from ods.nav_bridge.canopen.pose import CanopenPose
from ods.nav_bridge.canopen.recent import RecentEvent
from ods.nav_bridge.pose_fields import PoseMaker
from ods.nav_bridge.settings import STATUS_BITS, CanopenSettings, NavSettings
from ods.nav_bridge.source import SourceHost

SYNC_AGE_NS = 20_000_000
"""A SYNC older than this when an epoch begins did not trigger it."""
START_PERIOD_NS = NS
"""Between two commands that start the INS."""


class CanopenSource(CanSource):
    """One INS by its EDS, and the node that this process is. Counts `epoch_contested`: dropped while two INSs send."""

    def __init__(self, nav: NavSettings, settings: CanopenSettings, host: SourceHost) -> None:
        """Read both EDS files. Raises EdsError."""
        super().__init__(nav, host.now_ns)
        counters = host.counters
        self.monitor = InsMonitor(settings.heartbeat_timeout_s, host.now_ns, counters)
        self._settings = settings
        self._counters = counters
        try:
            objects = object_map(settings.objects)
        except OdsError as error:
            raise EdsError(f"{settings.ins_eds}: {error}") from error
        pdo_set = load_pdo_set(settings.ins_eds, settings.ins_node_id, objects)
        try:
            maker = PoseMaker(pdo_set.fields, host.frame, nav.limits, nav.sigma, host.utc, counters)
        except OdsError as error:
            raise EdsError(f"{settings.ins_eds}: with nav.canopen.objects: {error}") from error
        self._node = OwnNode(nav, settings, host.send, self.monitor, counters)
        self._layouts = {layout.cob_id: layout for layout in pdo_set.layouts}
        self._assembler = EpochAssembler(pdo_set, round(settings.epoch_window_s * NS), counters)
        self._maker = maker
        bits = STATUS_BITS if settings.status_bits is None else settings.status_bits
        for part, bit in bits.items():
            if settings.status_bits and bit >= pdo_set.status_bits:
                key = f"nav.canopen.status_bits.{part}"
                raise EdsError(f"{settings.ins_eds}: {key}: no bit {bit}: the status has {pdo_set.status_bits} bits")
        self._pose = CanopenPose(maker, bits, nav.clock_jump_s, host.utc, counters)
        self._handlers: dict[int, Callable[[Frame], object]] = {
            **dict.fromkeys(self._node.ids, self._node.take),
            SYNC: self.monitor.sync,
            TIME: self._pose.take_time,
            EMCY + settings.ins_node_id: self.monitor.emergency,
            HEARTBEAT + settings.ins_node_id: self.monitor.heartbeat,
        }
        taken = sorted(self._layouts.keys() & self._handlers.keys())
        if taken:
            raise EdsError(f"{settings.ins_eds}: a PDO has COB-ID 0x{taken[0]:X}, which another CANopen service needs")
        self._commanded_ns = host.now_ns - START_PERIOD_NS
        self._pdo_short, self._recovered = RecentEvent("pdo_short", counters), RecentEvent("can_recovered", counters)
        self._opened = self._reopened = False

    @property
    def ids(self) -> frozenset[CanId]:
        """Those of the PDOs, of the INS's other services, and of our own node."""
        return frozenset(CanId(number, extended=False) for number in {*self._layouts, *self._handlers})

    def expects(self) -> dict[str, str]:
        """Return the PDOs, and the heartbeat if it is waited for."""
        found = {layout.cob_id: " ".join(layout.fields) for layout in self._layouts.values()}
        if self._settings.heartbeat_timeout_s:
            found[HEARTBEAT + self._settings.ins_node_id] = "heartbeat"
        return {str(CanId(number, extended=False)): what for number, what in found.items()}

    def objections(self) -> list[str]:
        """Return a text that names the COB-IDs reserved for other services than PDOs."""
        cob_ids = [layout.cob_id for layout in self._layouts.values() if layout.restricted]
        listed = ", ".join(str(CanId(number, extended=False)) for number in sorted(cob_ids))
        asked = "is $NODEID missing in the EDS?"
        return [f"{listed}: CiA 301 reserves these COB-IDs for other services: {asked}"] if cob_ids else []

    @property
    def late_ns(self) -> int:
        """How late the newest epoch was."""
        return self._pose.late_ns

    def opened(self) -> None:
        """Announce our own node."""
        self._reopened, self._opened = self._opened, True
        self._node.opened()

    def tick(self, now_ns: int) -> None:
        """Keep our own node alive; start the INS if that is our job."""
        self._node.tick(now_ns, self._faults(now_ns))
        if self._settings.start_ins and self.waits_for_start(now_ns) and now_ns - self._commanded_ns > START_PERIOD_NS:
            self._commanded_ns = now_ns
            self._node.start_remote(self._settings.ins_node_id)

    def waits_for_start(self, now_ns: int) -> bool:
        """Return whether the INS says that it waits to be started; one without heartbeat may whenever it is silent."""
        silent = not self.monitor.timeout_ns and self.stale_ns(now_ns)
        return bool(silent) or self.monitor.state in (BOOT_UP, PRE_OPERATIONAL)

    def idle_ns(self, now_ns: int) -> int | None:
        """Return how long `tick` may wait: until the next SYNC, if we send it."""
        return self._node.idle_ns(now_ns)

    def _take(self, item: Frame) -> Pose | None:
        if item.extended:
            self._counters["can_extended"] += 1
            return None
        layout = self._layouts.get(item.can_id)
        if layout is None:
            handler = self._handlers.get(item.can_id)
            if handler is not None:
                handler(item)
            return None
        epoch = self._assembler.take(layout, item)
        return self._pose_of(epoch) if epoch else None

    def _pose_of(self, epoch: Epoch) -> Pose | None:
        self.monitor.received_epoch()
        if self._assembler.duplicate.now(epoch.t_ns):
            self._counters["epoch_contested"] += 1
            return None
        pose = self._pose.decode(epoch, self._sampled_ns(epoch))
        self._reopened = self._reopened and pose is None
        return pose

    def _faults(self, now_ns: int) -> Set[Fault]:
        found = {
            Fault.BUS_LOST: self._reopened,
            Fault.HEARTBEAT_LOST: self.monitor.silent_ns(now_ns),
            Fault.BUS_OFF_OVER: self._recovered.now(now_ns),
            Fault.PDO_SHORT: self._pdo_short.now(now_ns),
            Fault.NO_POSE: self.stale_ns(now_ns),
            Fault.INS_TWICE: self._is_twice(now_ns),
            Fault.OWN_ID_TAKEN: self._node.another.now(now_ns),
        }
        return {fault for fault, there in found.items() if there}

    def _complaints(self, now_ns: int) -> list[str]:
        found = [f"the INS says that its {part} is not valid" for part in self._pose.not_valid]
        if self._maker.disbelief:
            found.insert(0, self._maker.disbelief)
        if self._is_twice(now_ns):
            found.append(f"two nodes send as node {self._settings.ins_node_id}, the INS's id")
        if self._node.another.now(now_ns):
            found.append(f"another node sends as node {self._settings.node_id}, our own id")
        return found + self.monitor.problems(now_ns)

    def _is_twice(self, now_ns: int) -> bool:
        return self._assembler.duplicate.now(now_ns) or self.monitor.duplicate.now(now_ns)

    def _sampled_ns(self, epoch: Epoch) -> int:
        """Return when an epoch without valid time was sampled: at the SYNC before it, else at its arrival."""
        sync_ns = self.monitor.sync_ns
        return sync_ns if sync_ns is not None and 0 <= epoch.t_ns - sync_ns <= SYNC_AGE_NS else epoch.t_ns
