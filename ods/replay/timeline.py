"""Recorded instants, moved to now."""

from itertools import chain

import msgspec

from ods.messages import ObstacleList

FARTHEST_NS = 2**62
"""Bounds of the instants of messages."""


class Timeline:
    """Maps recorded instants to this computer's clocks: at speed 1 by an offset, otherwise also scaled.

    Both clocks are moved alike, each on to its own: what was 3 ms apart, of two topics or of two clocks, stays so at
    speed 1.
    """

    def __init__(self, speed: float, utc_offset_ns: int) -> None:
        """`utc_offset_ns`: UTC less the monotonic clock, of this computer."""
        self.speed = speed
        self._utc_offset_ns = utc_offset_ns
        self._recorded_ns = self._now_ns = 0

    def begin(self, recorded_ns: int, now_ns: int) -> None:
        """Let a recorded instant be now."""
        self._recorded_ns, self._now_ns = recorded_ns, now_ns

    def at(self, recorded_ns: int) -> int:
        """Return when a recorded instant is, monotonic."""
        since_ns = recorded_ns - self._recorded_ns
        return self._now_ns + (since_ns if self.speed == 1.0 else round(since_ns / self.speed))

    def utc(self, recorded_utc_ns: int, recorded_offset_ns: int) -> int:
        """Return when a recorded instant is, UTC; `recorded_offset_ns` as that of `__init__`, of the recording."""
        return self.at(recorded_utc_ns - recorded_offset_ns) + self._utc_offset_ns


def moved(message: msgspec.Struct, line: Timeline, recorded_offset_ns: int) -> msgspec.Struct:
    """Return a message with all its times moved: fields named *_ns, of which 0 means that there was none.

    Raises ValueError for a time that no message can hold.
    """
    changes: dict[str, object] = {}
    for name in message.__struct_fields__:
        value = getattr(message, name)
        if name == "made_utc_ns" and not value:
            continue
        if name.endswith("utc_ns"):
            changes[name] = line.utc(value, recorded_offset_ns)
        elif name.endswith("_ns") and value:
            changes[name] = [line.at(each) for each in value] if isinstance(value, list) else line.at(value)
    if isinstance(message, ObstacleList):
        changes["obstacles"] = [moved(o, line, recorded_offset_ns) for o in message.obstacles]
    times = chain.from_iterable(value if isinstance(value, list) else [value] for value in changes.values())
    if any(isinstance(value, int) and abs(value) > FARTHEST_NS for value in times):
        raise ValueError("a time is out of bounds")
    return msgspec.structs.replace(message, **changes)
