"""Load of the computer while the bench ran: wake-up delay, and share of a processor.

`python -m ods.bench.machine` measures until its standard input is closed, then prints a `MachineLoad` as JSON: in a
process of its own, as no thread of the bench may make it late.
"""

import os
import select
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType

import msgspec
import numpy as np

SLEEP_S = 0.005
SPIN_S = 0.002
"""Of processor time, once in each round."""
ROUND_S = 0.1
BUSY_WAKE_MS = 5.0
"""The computer is busy if one wake-up in twenty is later than this."""
BUSY_SLOWDOWN = 1.5
"""The computer is busy if one short piece of work in four takes this multiple of its processor time."""
BUSY_PRESSURE = 0.6
"""The computer is busy if a process waits for a processor for more than this share of the time."""


class MachineLoad(msgspec.Struct, frozen=True):
    """How busy the computer was; the defaults are those of an idle one."""

    load: float = 0.0
    """Mean number of processes that ran or waited for a processor, the bench's own included."""
    processors: int = 1
    pressure: float = 0.0
    """Share of the time in which some process waited for a processor (/proc/pressure/cpu); 0 where not reported."""
    wake_p95_ms: float = 0.0
    """How late a process that slept was woken."""
    slowdown_p75: float = 1.0
    """Wall time over processor time of a short piece of work."""

    @property
    def busy(self) -> bool:
        """Return whether times measured meanwhile say as much of the computer as of the program."""
        return self.wake_p95_ms > BUSY_WAKE_MS or self.slowdown_p75 > BUSY_SLOWDOWN or self.pressure > BUSY_PRESSURE

    def __str__(self) -> str:
        return f"load {self.load:.0f} on {self.processors} processors"


class MachineProbe:
    """Measures while the bench runs."""

    def __enter__(self) -> "MachineProbe":
        command = [sys.executable, "-P", "-m", __name__]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        return self

    def result(self) -> MachineLoad:
        """End the measurement and return what it found; an idle computer if it could not be measured."""
        output, _ = self._process.communicate()
        try:
            return msgspec.json.decode(output, type=MachineLoad)
        except msgspec.DecodeError:
            return MachineLoad()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self._process.kill()
        self._process.communicate()


def measure() -> MachineLoad:
    """Measure until standard input is closed."""
    wakes, slowdowns, loads = list[float](), list[float](), list[float]()
    pressed_us, begun = _pressed_us(), time.monotonic()
    while not wakes or not select.select([sys.stdin], [], [], ROUND_S)[0]:
        asleep = time.monotonic()
        time.sleep(SLEEP_S)
        wakes.append(1e3 * (time.monotonic() - asleep - SLEEP_S))
        slowdowns.append(_spin())
        loads.append(os.getloadavg()[0])
    elapsed_us = max(1e6 * (time.monotonic() - begun), 1.0)
    return MachineLoad(
        load=float(np.mean(loads)),
        processors=len(os.sched_getaffinity(0)),
        pressure=min((_pressed_us() - pressed_us) / elapsed_us, 1.0),
        wake_p95_ms=float(np.percentile(wakes, 95)),
        slowdown_p75=float(np.percentile(slowdowns, 75)),
    )


def _spin() -> float:
    wall, cpu = time.monotonic(), time.thread_time()
    while time.thread_time() - cpu < SPIN_S:
        pass
    return max((time.monotonic() - wall) / (time.thread_time() - cpu), 1.0)


def _pressed_us() -> int:
    try:
        return int(Path("/proc/pressure/cpu").read_text().partition("\n")[0].rpartition("total=")[2])
    except (OSError, ValueError):
        return 0


if __name__ == "__main__":
    sys.stdout.buffer.write(msgspec.json.encode(measure()))
