"""Choice of the objects that a map can do without."""

import math
from dataclasses import dataclass

from ods.base.clock import NS
from ods.tracker.map.map_object import MapObject

DAY_S = 86400.0


@dataclass(frozen=True, slots=True)
class Criteria:
    """An object goes when any one of these holds; None: not asked."""

    existence_below: float | None = None
    older_than_days: float | None = None
    """Last seen longer ago."""
    seen_fewer: int | None = None
    """Times seen."""
    outside: tuple[float, float, float] | None = None
    """Farther from a place than this: north, east, distance, m."""

    def __bool__(self) -> bool:
        return self != Criteria()


def why_not(o: MapObject, criteria: Criteria, now_utc_ns: int) -> list[str]:
    """Return why an object should go, in plain words; empty when it should stay."""
    reasons = []
    age_days = (now_utc_ns - o.last_seen_utc_ns) / NS / DAY_S
    if criteria.existence_below is not None and o.existence < criteria.existence_below:
        reasons.append(f"existence {o.existence:.3f}")
    if criteria.older_than_days is not None and age_days > criteria.older_than_days:
        reasons.append(f"last seen {age_days:.1f} days ago")
    if criteria.seen_fewer is not None and o.times_seen < criteria.seen_fewer:
        reasons.append(f"seen {o.times_seen} times")
    if criteria.outside is not None:
        north, east, distance = criteria.outside
        apart = math.hypot(o.position[0] - north, o.position[1] - east)
        if apart > distance:
            reasons.append(f"{apart:.0f} m away")
    return reasons
