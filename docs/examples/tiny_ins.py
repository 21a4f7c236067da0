"""An imaginary INS on CAN. Frames 0x201, 0x202 and 0x203, in this order, are one pose; each has three int16."""

import struct

from ods.messages import Pose
from ods.nav_bridge.can.frame import CanId, Frame
from ods.nav_bridge.can.source import CanSource
from ods.nav_bridge.pose_fields import PoseMaker
from ods.nav_bridge.settings import NavSettings
from ods.nav_bridge.source import SourceHost

_NUMBERS = struct.Struct("<hhh")
_FIELDS = {
    CanId(0x201, False): (("north", 0.1), ("east", 0.1), ("down", 0.1)),
    CanId(0x202, False): (("roll", 1e-3), ("pitch", 1e-3), ("yaw", 1e-3)),
    CanId(0x203, False): (("u", 1e-3), ("v", 1e-3), ("w", 1e-3)),
}
"""By frame: names of the pose fields, and what turns a count into SI units."""
_FIRST, *_, _LAST = _FIELDS


class TinySource(CanSource):
    """One such INS. Counts `frame_short`, and what PoseMaker does."""

    def __init__(self, nav: NavSettings, host: SourceHost) -> None:
        super().__init__(nav, host.now_ns)
        names = [name for fields in _FIELDS.values() for name, _ in fields]
        self._maker = PoseMaker(names, host.frame, nav.limits, nav.sigma, host.utc, host.counters)
        self._counters = host.counters
        self._values: dict[str, float] = {}
        self._begun_ns = 0

    @property
    def ids(self) -> frozenset[CanId]:
        """The three frames."""
        return frozenset(_FIELDS)

    def expects(self) -> dict[str, str]:
        """Return what each carries."""
        return {str(can_id): ", ".join(name for name, _ in fields) for can_id, fields in _FIELDS.items()}

    def _take(self, item: Frame) -> Pose | None:
        can_id = CanId(item.can_id, item.extended)
        if len(item.data) < _NUMBERS.size:
            self._counters["frame_short"] += 1
            return None
        if can_id == _FIRST:
            self._values, self._begun_ns = {}, item.t_ns
        for (name, factor), count in zip(_FIELDS[can_id], _NUMBERS.unpack_from(item.data), strict=True):
            self._values[name] = factor * count
        whole = can_id == _LAST and len(self._values) == 3 * len(_FIELDS)
        return self._maker.make(self._values, self._begun_ns, item.t_ns) if whole else None

    def _complaints(self, now_ns: int) -> list[str]:
        return []
