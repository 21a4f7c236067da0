"""Keeps a process small: gives memory that has done its work back to the system."""

import ctypes
import mmap
import re
from collections.abc import Iterator
from pathlib import Path

_MAPS = Path("/proc/self/smaps")
_HEAD = re.compile(r"^([0-9a-f]+)-([0-9a-f]+) \S+ \S+ \S+ \S+ *(.*)$")


_ARENA_MAX = -8
"""Of glibc's mallopt."""


def share_one_pool() -> None:
    """Let threads share the pool that they allocate from: glibc would keep what was freed in one for each of them.

    To be called before there are threads. Other C libraries are left as they are.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_ARENA_MAX, 1)


def give_back_freed() -> None:
    """Give back what this process has freed: it takes milliseconds, and as long again when it is needed next."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)


def give_back(library: str) -> None:
    """Give back what is in memory of the library with this word in its file's name, as far as the file tells it, too.

    So is what it has freed. The system reads a page again where it is needed after all. Without /proc (not Linux)
    nothing is done.
    """
    try:
        told = _MAPS.read_text()
    except OSError:
        return
    advise = ctypes.CDLL(None).madvise
    advise.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
    for start, end in clean_parts(told, library):
        advise(start, end - start, mmap.MADV_DONTNEED)
    give_back_freed()


def clean_parts(told: str, library: str) -> Iterator[tuple[int, int]]:
    """Yield first address and end of each part of a library that was never written to; told: as /proc/PID/smaps."""
    part: tuple[int, int] | None = None
    for line in told.splitlines():
        if head := _HEAD.match(line):
            part = (int(head[1], 16), int(head[2], 16)) if library in Path(head[3]).name else None
        elif part and line.split() == ["Anonymous:", "0", "kB"]:  # a page that was written to is the process's own
            yield part
