"""The one module that reads the machine's clocks, and the units of time."""

import ctypes
import time
from functools import cache

NS = 1_000_000_000
"""Nanoseconds in a second."""
MS = 1_000_000
"""Nanoseconds in a millisecond."""
DAY_MS = 86_400_000
"""Milliseconds in a day."""
NOT_SYNCHRONIZED = 5
"""What adjtimex(2) returns, TIME_ERROR; below 0 it may not be asked."""


def monotonic_ns() -> int:
    """Return CLOCK_MONOTONIC, ns: the time base of everything inside one machine."""
    return time.monotonic_ns()


def utc_ns(t_ns: int | None = None) -> int:
    """Return UTC, ns since 1970, of the monotonic instant `t_ns` (now by default), by today's offset of both clocks."""
    return time.time_ns() if t_ns is None else t_ns + utc_offset_ns()


def utc_offset_ns() -> int:
    """Return UTC - CLOCK_MONOTONIC now, ns: the best of three readings, as a thread switch may fall into one."""
    readings = []
    for _ in range(3):
        before, utc, after = time.monotonic_ns(), time.time_ns(), time.monotonic_ns()
        readings.append((after - before, utc - (before + after) // 2))
    return min(readings)[1]


def synchronized() -> bool:
    """Return whether the kernel knows of somebody who keeps UTC right: NTP, PTP."""
    timex = ctypes.create_string_buffer(512)
    state: int = _libc().adjtimex(timex)
    return 0 <= state < NOT_SYNCHRONIZED


@cache
def _libc() -> ctypes.CDLL:
    """Return the C library, opened once: asked for each pose, looking it up took 25 us."""
    return ctypes.CDLL(None)
