"""CANopen epochs to poses: validity by status bits, instant by the INS's time of day."""

from collections import Counter
from collections.abc import Mapping

from ods.base.clock import NS
from ods.messages import Pose
from ods.nav_bridge.canopen.epoch import Epoch
from ods.nav_bridge.canopen.object_map import STATUS_FIELD
from ods.nav_bridge.clocks.ins_clock import InsClock, day_ms
from ods.nav_bridge.pose_fields import OVER_BOTTOM, PoseMaker


class CanopenPose:
    """Makes a `Pose` of each sound epoch.

    Counts `epoch_invalid` (status bits), `epoch_untimed` (no valid time of day: arrival taken instead), and
    `ins_clock_wild` and `ins_clock_jumps`, which are those of `OffsetEstimator`.
    """

    def __init__(
        self, maker: PoseMaker, status_bits: Mapping[str, int], clock_jump_s: float, counters: Counter[str]
    ) -> None:
        self.not_valid: list[str] = []
        """Parts of the pose that the newest epoch says are not valid."""
        self._maker = maker
        masks = {part: 1 << bit for part, bit in status_bits.items()}
        self._timed, self._over_bottom = masks.pop("time_of_day", 0), masks.pop("altitude", 0)
        self._needed = masks
        self._counters = counters
        self._clock = InsClock(round(clock_jump_s * NS))

    @property
    def late_ns(self) -> int:
        """How late the newest epoch was, by the INS's clock."""
        return self._clock.late_ns

    def knows_time(self, epoch: Epoch) -> bool:
        """Return whether the INS says that its time is valid; one without such a status does not say so."""
        return bool(self._timed) and int(epoch.values.get(STATUS_FIELD, 0)) & self._timed == self._timed

    def decode(self, epoch: Epoch, instant_ns: int) -> Pose | None:
        """Return the pose, or None; `instant_ns` is taken when the INS reports no valid time."""
        status = int(epoch.values.get(STATUS_FIELD, -1))  # an INS without a status always is as it says
        self.not_valid = [part for part, mask in self._needed.items() if not status & mask]
        if self.not_valid:
            self._counters["epoch_invalid"] += 1
            return None
        values = dict(epoch.values)
        if status & self._over_bottom != self._over_bottom:
            values.pop(OVER_BOTTOM, None)
        return self._maker.make(values, self._instant(epoch, status, instant_ns), epoch.t_ns)

    def _instant(self, epoch: Epoch, status: int, instant_ns: int) -> int:
        milliseconds = day_ms(epoch.values["time_ms"]) if "time_ms" in epoch.values else None
        if milliseconds is None or status & self._timed != self._timed:
            self._counters["epoch_untimed"] += 1
            return instant_ns
        t_ns = self._clock.instant(milliseconds, epoch.t_ns)
        self._counters["ins_clock_jumps"] = self._clock.estimator.jumps
        self._counters["ins_clock_wild"] = self._clock.estimator.wild
        return t_ns
