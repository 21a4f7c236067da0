"""Values of messages that come at rates of their own, held until their next one comes or they are too old."""

from collections.abc import Iterable, Iterator

from ods.base.clock import NS
from ods.nav_bridge.dbc.signal_map import DbcMessage
from ods.nav_bridge.pose_fields import UNITS, Age
from ods.nav_bridge.settings import HeldSettings


class _Slot:
    """The newest values of one message."""

    def __init__(self, message: DbcMessage, settings: HeldSettings) -> None:
        self.message, self.settings = message, settings
        self.values: dict[str, float] = {}
        self.t_ns: int | None = None
        angle, length = settings.growth_rad_s, settings.growth_m_s
        self.growth = {item.field: length if UNITS[item.field] in ("m", "deg") else angle for item in message.readings}

    def age_s(self, t_ns: int) -> float:
        """Return the age at an instant; one that was read late, as after a stall, may lie before the arrival."""
        return float("inf") if self.t_ns is None else abs(t_ns - self.t_ns) / NS


class HeldValues:
    """The newest values of all held messages, with their ages."""

    def __init__(self, messages: Iterable[DbcMessage]) -> None:
        self._slots = {message.can_id: _Slot(message, message.hold) for message in messages if message.hold is not None}

    def take(self, message: DbcMessage, counts: dict[str, float], t_ns: int) -> None:
        """Take the raw counts of one held message."""
        slot = self._slots[message.can_id]
        slot.values, slot.t_ns = {}, t_ns
        message.add_to(slot.values, counts)

    def add_to(self, values: dict[str, float], t_ns: int) -> dict[str, Age] | None:
        """Add what is held to the values of an instant and return the ages, None when something is too old."""
        ages: dict[str, Age] = {}
        for slot in self._slots.values():
            age_s = slot.age_s(t_ns)
            if age_s > slot.settings.max_age_s:
                return None
            values |= slot.values
            for name, growth in slot.growth.items():
                ages[name] = Age(age_s, growth)
        return ages

    def too_old(self, now_ns: int) -> Iterator[str]:
        """Say which messages came but are too old."""
        for slot in self._slots.values():
            age_s, name = slot.age_s(now_ns), slot.message.layout.name
            if slot.t_ns is not None and age_s > slot.settings.max_age_s:
                limit = f"nav.dbc.held.{name}.max_age_s is {slot.settings.max_age_s:g}"
                yield f"{slot.message.label}: last came {age_s:.1f} s ago, {limit}"
