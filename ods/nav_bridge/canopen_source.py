"""A CANopen navigation system: its PDOs, what else it says, and our own node beside it."""

from collections import Counter
from collections.abc import Callable

from ods.clock import NS
from ods.geodesy import LocalFrame
from ods.messages import Pose
from ods.nav_bridge.can_frame import EMCY, HEARTBEAT, SYNC, TIME, CanId, Frame
from ods.nav_bridge.canopen_pose import CanopenPose
from ods.nav_bridge.epoch import Epoch, EpochAssembler
from ods.nav_bridge.ins_monitor import PRE_OPERATIONAL, InsMonitor
from ods.nav_bridge.own_node import OwnNode
from ods.nav_bridge.pdo_layout import load_pdo_set
from ods.nav_bridge.pose_fields import PoseMaker
from ods.nav_bridge.settings import CanopenSettings, NavSettings
from ods.nav_bridge.source import PoseSource, Send

SYNC_AGE_NS = 20_000_000
"""A SYNC older than this when an epoch begins did not trigger it."""
START_PERIOD_NS = NS
"""Between two commands that start the INS."""


class CanopenSource(PoseSource):
    """One INS by its EDS, and the node that this process is."""

    def __init__(
        self,
        nav: NavSettings,
        settings: CanopenSettings,
        frame: LocalFrame,
        send: Send,
        now_ns: int,
        utc_of: Callable[[int], int],
        counters: Counter[str],
    ) -> None:
        super().__init__(nav.stale_s, now_ns)
        self.monitor = InsMonitor(settings.heartbeat_timeout_s, now_ns, counters)
        self._settings = settings
        self._counters = counters
        pdo_set = load_pdo_set(settings.ins_eds, settings.ins_node_id)
        fields = {name for layout in pdo_set.layouts for name in layout.fields}
        maker = PoseMaker(fields, frame, nav.limits, nav.sigma, utc_of, counters)
        self._node = OwnNode(settings, send, counters)
        self._layouts = {layout.cob_id: layout for layout in pdo_set.layouts}
        self._assembler = EpochAssembler(pdo_set, counters)
        self._pose = CanopenPose(maker, nav.clock_jump_s, counters)
        self._handlers: dict[int, Callable[[Frame], object]] = {
            **dict.fromkeys(self._node.ids, self._node.take),
            SYNC: self.monitor.sync,
            TIME: self.monitor.time,
            EMCY + settings.ins_node_id: self.monitor.emergency,
            HEARTBEAT + settings.ins_node_id: self.monitor.heartbeat,
        }
        self._utc_of = utc_of
        self._commanded_ns = now_ns - START_PERIOD_NS

    @property
    def ids(self) -> frozenset[CanId]:
        """Those of the PDOs, of the INS's other services, and of our own node."""
        return frozenset(CanId(number, extended=False) for number in {*self._layouts, *self._handlers})

    def expects(self) -> dict[CanId, str]:
        """Return the PDOs, and the heartbeat if it is waited for."""
        found = {CanId(layout.cob_id, extended=False): " ".join(layout.fields) for layout in self._layouts.values()}
        if self._settings.heartbeat_timeout_s:
            found[CanId(HEARTBEAT + self._settings.ins_node_id, extended=False)] = "heartbeat"
        return found

    def opened(self) -> None:
        """Announce our own node."""
        self._node.boot()

    def tick(self, now_ns: int) -> None:
        """Keep our own node alive; start the INS if that is our job."""
        self._node.tick(now_ns)
        wanted = self._settings.start_ins and self.monitor.state == PRE_OPERATIONAL
        if wanted and now_ns - self._commanded_ns > START_PERIOD_NS:
            self._commanded_ns = now_ns
            self._node.start_remote(self._settings.ins_node_id)

    def _take(self, frame: Frame) -> Pose | None:
        if frame.extended:
            self._counters["can_extended"] += 1
            return None
        layout = self._layouts.get(frame.can_id)
        if layout is None:
            handler = self._handlers.get(frame.can_id)
            if handler is not None:
                handler(frame)
            return None
        epoch = self._assembler.take(layout, frame)
        return self._pose.decode(epoch, self._sampled_ns(epoch)) if epoch else None

    def _complaints(self, now_ns: int) -> list[str]:
        not_valid = [f"the INS says that its {part} is not valid" for part in self._pose.not_valid]
        return not_valid + self.monitor.problems(now_ns, self._utc_of(now_ns))

    def _sampled_ns(self, epoch: Epoch) -> int:
        """Return when an epoch without valid time was sampled: at the SYNC before it, else at its arrival."""
        sync_ns = self.monitor.sync_ns
        if sync_ns is not None and 0 <= epoch.t_ns - sync_ns <= SYNC_AGE_NS:
            return sync_ns
        return epoch.t_ns
