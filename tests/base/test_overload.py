"""A process that waits for a processor is reported from one that sleeps, that works, and that waits for a disk."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator

import pytest

from ods.base.clock import NS
from ods.base.computer.overload import (
    OVERLOADED,
    OverloadMonitor,
    ProcessorTime,
    is_starved,
    processor_time,
    waits_for_processor,
)

SPIN = [sys.executable, "-c", "while True: pass"]


@pytest.fixture
def rivals() -> Iterator[int]:
    """Return the processor that this process and four busy ones share; this one is to be nice to them."""
    before = os.sched_getaffinity(0)
    only = min(before)
    os.sched_setaffinity(0, {only})
    busy = [subprocess.Popen(SPIN) for _ in range(4)]
    yield only
    for process in busy:
        process.kill()
        process.wait()
    os.sched_setaffinity(0, before)


@pytest.mark.parametrize(
    ("spent", "starved"),
    [
        (ProcessorTime(0, 0), False),
        (ProcessorTime(NS, 0), False),
        (ProcessorTime(NS // 10, NS // 2), True),
        (ProcessorTime(NS // 2, NS // 3), False),  # slow, but it gets more than it waits for
        (ProcessorTime(NS // 100, NS // 10), False),  # it wants little
    ],
)
def test_what_counts_as_starved(spent: ProcessorTime, starved: bool) -> None:
    assert is_starved(spent, NS) == starved


def test_a_process_among_busy_ones_is_starved(rivals: int) -> None:
    victim = subprocess.Popen(SPIN)
    monitor = OverloadMonitor(victim.pid)
    try:
        monitor.look(time.monotonic_ns())
        deadline_s = time.monotonic() + 20.0
        while not monitor.starved(time.monotonic_ns()):
            assert time.monotonic() < deadline_s
            time.sleep(0.1)
        assert monitor.problem(time.monotonic_ns()).startswith(OVERLOADED)
    finally:
        victim.kill()
        victim.wait()


def test_a_process_that_sleeps_is_not_starved_among_busy_ones(rivals: int) -> None:
    with subprocess.Popen(["sleep", "60"]) as sleeper:
        monitor = OverloadMonitor(sleeper.pid)
        time.sleep(0.2)  # it starts
        monitor.look(time.monotonic_ns())
        time.sleep(0.5)
        assert monitor.starved(time.monotonic_ns()) == ""
        sleeper.kill()


def test_a_process_that_is_gone_has_no_time() -> None:
    process = subprocess.Popen(["true"])
    process.wait()
    assert processor_time(process.pid) == ProcessorTime(0, 0)
    assert not waits_for_processor(process.pid)


def test_nothing_is_said_before_the_first_look() -> None:
    assert OverloadMonitor().problem(time.monotonic_ns()) == ""
