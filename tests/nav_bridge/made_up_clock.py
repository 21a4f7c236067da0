"""UTC for a source in a test."""

from ods.nav_bridge.clocks.utc import Utc, WallClock


def utc_ahead(ahead_ns: int) -> Utc:
    """Return the UTC of a synchronized clock that is so far ahead of CLOCK_MONOTONIC."""
    return Utc(lambda: WallClock(ahead_ns, synchronized=True))
