"""CANopen epochs to poses: validity by status bits, instant by the INS's time of day, UTC by the network's TIME."""

import struct
from collections import Counter
from collections.abc import Mapping

from ods.base.clock import DAY_MS, MS, NS
from ods.messages import Pose
from ods.nav_bridge.can.frame import Frame
from ods.nav_bridge.canopen.epoch import Epoch
from ods.nav_bridge.canopen.object_map import STATUS_FIELD
from ods.nav_bridge.clocks.ins_clock import InsClock
from ods.nav_bridge.clocks.utc import ReportedUtc, Utc
from ods.nav_bridge.pose_fields import OVER_BOTTOM, PoseMaker

TIME_FRAME = struct.Struct("<IH")
MASK_28_BIT = (1 << 28) - 1
"""TIME_OF_DAY has four reserved bits above its milliseconds (CiA 301)."""
DAYS_1970_TO_1984 = 5113
"""TIME_OF_DAY counts days from 1984-01-01."""


class CanopenPose:
    """Makes a `Pose` of each sound epoch.

    Counts `epoch_invalid` (status bits), `epoch_untimed` (no valid time of day: arrival taken instead), `time_bad`
    (malformed, too), and what `InsClock` and `ReportedUtc` do.
    """

    def __init__(
        self, maker: PoseMaker, status_bits: Mapping[str, int], clock_jump_s: float, utc: Utc, counters: Counter[str]
    ) -> None:
        self.not_valid: list[str] = []
        """Parts of the pose that the newest epoch says are not valid."""
        self._maker = maker
        masks = {part: 1 << bit for part, bit in status_bits.items()}
        self._timed, self._over_bottom = masks.pop("time_of_day", 0), masks.pop("altitude", 0)
        self._needed = masks
        self._counters = counters
        self._clock = InsClock(round(clock_jump_s * NS), counters)
        self._utc, self._network_utc = utc, ReportedUtc(counters)

    @property
    def late_ns(self) -> int:
        """How late the newest epoch was, by the INS's clock."""
        return self._clock.late_ns

    def take_time(self, frame: Frame) -> None:
        """Take a TIME message of the network."""
        raw, days = TIME_FRAME.unpack(frame.data) if len(frame.data) == TIME_FRAME.size else (-1, 0)
        milliseconds = _day_ms(raw) if raw >= 0 else None
        if milliseconds is None:
            self._counters["time_bad"] += 1
            return
        self._network_utc.take(((days + DAYS_1970_TO_1984) * DAY_MS + milliseconds) * MS, frame.t_ns)

    def decode(self, epoch: Epoch, instant_ns: int) -> Pose | None:
        """Return the pose, or None; `instant_ns` is taken when the INS reports no valid time."""
        status = int(epoch.values.get(STATUS_FIELD, -1))  # an INS without a status always is as it says
        is_timed = status & self._timed == self._timed
        says_so = is_timed and self._timed > 0 and STATUS_FIELD in epoch.values
        self._utc.take(self._network_utc.ahead_ns if says_so else None)
        self.not_valid = [part for part, mask in self._needed.items() if not status & mask]
        if self.not_valid:
            self._counters["epoch_invalid"] += 1
            return None
        values = dict(epoch.values)
        if status & self._over_bottom != self._over_bottom:
            values.pop(OVER_BOTTOM, None)
        milliseconds = _day_ms(values["time_ms"]) if is_timed and "time_ms" in values else None
        if milliseconds is None:
            self._counters["epoch_untimed"] += 1
        else:
            instant_ns = self._clock.instant(milliseconds, epoch.t_ns)
        return self._maker.make(values, instant_ns, epoch.t_ns)


def _day_ms(raw: float) -> int | None:
    """Return the milliseconds since midnight of a raw TIME_OF_DAY count, None when no day is that long."""
    milliseconds = int(raw) & MASK_28_BIT
    return milliseconds if milliseconds < DAY_MS else None
