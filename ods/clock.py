"""The one module that reads the wall clock and maps clocks onto CLOCK_MONOTONIC."""

import time

NS = 1_000_000_000


def monotonic_ns() -> int:
    """Return CLOCK_MONOTONIC, ns: the time base of everything inside one machine."""
    return time.monotonic_ns()


def utc_ns(t_ns: int | None = None) -> int:
    """Return UTC, ns since 1970, of the monotonic instant `t_ns` (now by default), by today's offset of both clocks."""
    now = time.time_ns()
    return now if t_ns is None else now - time.monotonic_ns() + t_ns
