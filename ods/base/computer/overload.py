"""Is the computer overloaded? How long processes waited for a processor, by the kernel's accounts.

A process that gets no processor looks like one that hangs, or whose disk or device does not answer. The kernel knows
which it is: `/proc/PID/task/*/schedstat` has the time that each thread ran and the time that it was ready to run and
waited; `/proc/pressure/cpu` the time in which any process of the computer waited (Linux 4.20, if so configured).
"""

import os
from collections import deque
from pathlib import Path
from typing import NamedTuple

from ods.base.clock import NS

OVERLOADED = "the computer is overloaded"
STARVED = f"{OVERLOADED}: processes wait for a processor"
"""In one wording, so that it is one and the same reason from list to list."""
WINDOW_NS = 3 * NS
"""Waiting is judged over the last seconds."""
WAITED = 0.3
"""Share of the time: a process that waited for a processor for longer, and for longer than it ran, is starved."""
PRESSED = 0.8
"""The computer is overloaded when some process waited for a processor for a larger share of the time."""


class ProcessorTime(NamedTuple):
    """Of all threads of a process, since they started."""

    ran_ns: int
    waited_ns: int
    """Ready to run, but on no processor."""

    def since(self, earlier: "ProcessorTime") -> "ProcessorTime":
        """Return what has been added since; threads that have ended meanwhile take theirs away."""
        return ProcessorTime(max(0, self.ran_ns - earlier.ran_ns), max(0, self.waited_ns - earlier.waited_ns))

    @property
    def total_ns(self) -> int:
        """Time in which it did not sleep and waited for no device."""
        return self.ran_ns + self.waited_ns


NO_TIME = ProcessorTime(0, 0)


def processor_time(pid: int) -> ProcessorTime:
    """Return the time of a process; `NO_TIME` where the kernel does not report."""
    ran_ns = waited_ns = 0
    try:
        threads = list(Path(f"/proc/{pid}/task").iterdir())
    except OSError:
        return NO_TIME
    for thread in threads:
        ran, waited = _of_thread(thread / "schedstat")
        ran_ns, waited_ns = ran_ns + ran, waited_ns + waited
    return ProcessorTime(ran_ns, waited_ns)


def is_starved(spent: ProcessorTime, within_ns: int) -> bool:
    """Return whether a process that spent this time within a period got much less of a processor than it asked for."""
    return spent.waited_ns > WAITED * within_ns and spent.waited_ns > spent.ran_ns


def waits_for_processor(thread: int) -> bool:
    """Return whether a thread of this process is ready to run, rather than waiting for a disk or a device."""
    try:
        return Path(f"/proc/self/task/{thread}/stat").read_text().rpartition(")")[2].split()[0] == "R"
    except (OSError, IndexError):
        return False


def _of_thread(file: Path) -> tuple[int, int]:
    try:
        ran, waited, *_ = file.read_text().split()
        return int(ran), int(waited)
    except (OSError, ValueError):
        return 0, 0


class OverloadMonitor:
    """Samples a process, by default this one, and the computer as a whole, from time to time."""

    def __init__(self, pid: int | None = None) -> None:
        self._pid = os.getpid() if pid is None else pid
        self._seen: deque[tuple[int, ProcessorTime, int]] = deque()

    def look(self, now_ns: int) -> None:
        """Record the processor times until now, CLOCK_MONOTONIC ns; call it about once a second."""
        self._seen.append((now_ns, processor_time(self._pid), _pressed_ns()))
        while len(self._seen) > 2 and now_ns - self._seen[1][0] >= WINDOW_NS:
            self._seen.popleft()

    def starved(self, now_ns: int) -> str:
        """Return one line if the process itself gets too little of a processor, "" if not."""
        if not self._seen:
            return ""
        then_ns, before, _ = self._seen[0]
        within_ns = max(now_ns - then_ns, 1)
        spent = processor_time(self._pid).since(before)
        return STARVED if is_starved(spent, within_ns) else ""

    def problem(self, now_ns: int) -> str:
        """Return one line if the process is starved, or some process of the computer nearly always; "" if not."""
        if found := self.starved(now_ns):
            return found
        if not self._seen:
            return ""
        then_ns, _, pressed_ns = self._seen[0]
        pressed = (_pressed_ns() - pressed_ns) / max(now_ns - then_ns, 1)
        return STARVED if pressed > PRESSED else ""


def _pressed_ns() -> int:
    """Return how long some process of the computer waited for a processor, ns; 0 where the kernel does not report."""
    try:
        line = Path("/proc/pressure/cpu").read_text().partition("\n")[0]
        return int(line.rpartition("total=")[2]) * 1000
    except (OSError, ValueError):
        return 0
