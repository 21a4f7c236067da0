"""Keeps a process small: gives memory that has done its work back to the system."""

import ctypes

_ARENA_MAX = -8
"""Of glibc's mallopt."""


def use_one_arena() -> None:
    """Let threads share the pool that they allocate from: glibc would keep what was freed in one for each of them.

    To be called before there are threads. Other C libraries are left as they are.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_ARENA_MAX, 1)


def release_freed_memory() -> None:
    """Give back what this process has freed: it takes milliseconds, and as long again when it is needed next."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
