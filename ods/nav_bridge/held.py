"""Values with a rate of their own, held until the next ones arrive or they are too old."""

from collections.abc import Collection, Iterable, Iterator
from math import inf

from ods.base.clock import NS
from ods.nav_bridge.pose_fields import OPTIONAL, UNITS, Age
from ods.nav_bridge.settings import HeldSettings


class HeldSlot:
    """The newest values of one message or sentence."""

    def __init__(self, label: str, key: str, settings: HeldSettings, fields: Collection[str]) -> None:
        """`label`: what people call it; `key`: of its settings; `fields`: those of the pose that it carries."""
        self.label, self.key = label, key
        self.max_age_s = settings.max_age_s
        self.values: dict[str, float] = {}
        self.refused_ns: int | None = None
        """When it last said of itself that it is not valid, if that was the newest that came,"""
        self.why = ""
        """and why, where it says that."""
        self.sigma_m = 0.0
        """What comes to the standard deviation of its lengths."""
        self.optional = OPTIONAL.issuperset(fields)
        """A pose is as good without it."""
        self._t_ns: int | None = None
        self.growth_m_s = settings.growth_m_s
        angle, length = settings.growth_rad_s, settings.growth_m_s
        self.growth = {name: length if UNITS[name] in ("m", "deg") else angle for name in fields}

    def take(self, values: dict[str, float], t_ns: int, sigma_m: float = 0.0) -> None:
        """Take new values and their instant; sigma_m: what comes to the standard deviation of lengths."""
        self.values, self._t_ns, self.refused_ns, self.sigma_m = values, t_ns, None, sigma_m

    def refuse(self, t_ns: int, why: str) -> None:
        """Take note that it is not valid at a time."""
        self.refused_ns, self.why = t_ns, why

    def age_s(self, t_ns: int) -> float:
        """Return the age at an instant; one that was read late, as after a stall, may lie before the arrival."""
        return inf if self._t_ns is None else abs(t_ns - self._t_ns) / NS

    def complaint(self, now_ns: int) -> str:
        """Return a text that it is too old, "" while it is not, or has never come."""
        age_s = self.age_s(now_ns)
        if age_s <= self.max_age_s or (self._t_ns is None and self.refused_ns is None):
            return ""
        if self.refused_ns is not None:
            since = f"for {age_s:.1f} s" if self._t_ns is not None else "since it first came"
            return f"{self.label}: has been flagged as not valid {since}" + (f" ({self.why})" if self.why else "")
        return f"{self.label}: last came {age_s:.1f} s ago, {self.key}.max_age_s is {self.max_age_s:g}"


class HeldValues:
    """The newest values of all that is held, with their ages."""

    def __init__(self, slots: Iterable[HeldSlot]) -> None:
        self._slots = list(slots)

    def add_to(self, values: dict[str, float], t_ns: int) -> dict[str, Age] | None:
        """Add what is held to the values of an instant and return the ages, None when what a pose needs is too old."""
        ages: dict[str, Age] = {}
        for slot in self._slots:
            age_s = slot.age_s(t_ns)
            if age_s > slot.max_age_s:
                if slot.optional:
                    continue
                return None
            values |= slot.values
            for name, growth in slot.growth.items():
                ages[name] = Age(age_s, growth, slot.sigma_m if UNITS[name] in ("m", "deg") else 0.0)
        return ages

    def too_old(self, now_ns: int) -> Iterator[str]:
        """Yield which came but are too old, of those that a pose needs."""
        yield from filter(None, (slot.complaint(now_ns) for slot in self._slots if not slot.optional))
