"""Keeps a process small: gives memory that has done its work back to the system."""

import ctypes

_ARENA_MAX = -8
"""Of glibc's mallopt."""


def use_one_arena() -> None:
    """Let threads share one allocation arena: glibc would keep freed memory in a separate one for each thread.

    To be called before there are threads. Other C libraries are left as they are.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_ARENA_MAX, 1)


def release_freed_memory() -> None:
    """Return freed memory to the system: this takes milliseconds, and as long again when the memory is needed next."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
