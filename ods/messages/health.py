"""Health of a process, by its own report."""

import msgspec

from ods.messages.fields import Count


class Health(msgspec.Struct, frozen=True):
    """State of a process."""

    process: str
    pid: int
    seq: Count
    t_ns: int
    utc_ns: int
    ready: bool
    problems: list[str]
    """In plain language; empty when all is well."""
    counters: dict[str, int]
    """Since start: [counters](../counters/README.md)."""
    rates_hz: dict[str, float]
    """By topic, of the last period."""
    ages_s: dict[str, float]
    """Since the newest message of each topic read; -1: none."""
    lags: dict[str, int]
    """Longest queue of each topic since the last report."""
    cpu_percent: float
    """Of one core."""
    rss_mb: float
