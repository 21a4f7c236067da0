"""Everything received from the INS, without I/O: CAN frames in, poses and plain words out."""

from collections import Counter
from collections.abc import Callable

from ods.clock import NS
from ods.messages import Pose
from ods.nav_bridge.can_frame import EMCY, HEARTBEAT, SYNC, TIME, Frame
from ods.nav_bridge.epoch import Epoch, EpochAssembler
from ods.nav_bridge.ins_monitor import InsMonitor
from ods.nav_bridge.pdo_layout import PdoSet
from ods.nav_bridge.pose_decoder import PoseDecoder
from ods.nav_bridge.settings import NavSettings

SYNC_AGE_NS = 20_000_000
"""A SYNC older than this when an epoch begins did not trigger it."""


class InsReceiver:
    """One INS as its frames tell of it."""

    def __init__(
        self,
        settings: NavSettings,
        pdo_set: PdoSet,
        now_ns: int,
        utc_of: Callable[[int], int],
        counters: Counter[str],
    ) -> None:
        self.monitor = InsMonitor(settings.heartbeat_timeout_s, now_ns, counters)
        self._counters = counters
        self._layouts = {layout.cob_id: layout for layout in pdo_set.layouts}
        self._assembler = EpochAssembler(pdo_set, counters)
        self._decoder = PoseDecoder(settings.limits, settings.clock_jump_s, counters, utc_of)
        self._handlers: dict[int, Callable[[Frame], None]] = {
            SYNC: self.monitor.sync,
            TIME: self.monitor.time,
            EMCY + settings.ins_node_id: self.monitor.emergency,
            HEARTBEAT + settings.ins_node_id: self.monitor.heartbeat,
        }
        self._stale_ns = round(settings.stale_s * NS)
        self._utc_of = utc_of
        self._start_ns = now_ns
        self._pose_ns: int | None = None

    @property
    def ids(self) -> frozenset[int]:
        """Standard CAN identifiers that `take` wants."""
        return frozenset(self._layouts) | frozenset(self._handlers)

    def take(self, frame: Frame) -> Pose | None:
        """Take one frame; return the pose that it completes."""
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
        pose = self._decoder.decode(epoch, self._sampled_ns(epoch)) if epoch else None
        if pose is not None:
            self._pose_ns = frame.t_ns
        return pose

    def problems(self, now_ns: int) -> list[str]:
        """Say in plain words what is wrong with INS and pose."""
        found = []
        last_ns = self._start_ns if self._pose_ns is None else self._pose_ns
        if now_ns - last_ns > self._stale_ns:
            found.append(f"no pose for {(now_ns - last_ns) / NS:.1f} s")
            found += [f"the INS says that its {part} is not valid" for part in self._decoder.not_valid]
        return found + self.monitor.problems(now_ns, self._utc_of(now_ns))

    def _sampled_ns(self, epoch: Epoch) -> int:
        """Return when an epoch without valid time was sampled: at the SYNC before it, else at its arrival."""
        sync_ns = self.monitor.sync_ns
        if sync_ns is not None and 0 <= epoch.t_ns - sync_ns <= SYNC_AGE_NS:
            return sync_ns
        return epoch.t_ns
