"""The whole chain on a computer with many times as much to do as it has processors: starvation is reported as that."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from ods.base.computer.overload import OVERLOADED
from ods.base.settings_file import load
from ods.bench import runner
from ods.bench.settings import BenchConfig
from ods.offline.run_record import RunRecord
from ods.runtime.bus import BusSettings

CONFIG = Path(__file__).parents[2] / "config" / "bench.toml"
RIVALS = 5
"""Busy loops a processor."""
SECONDS = 25.0
WRONG_CAUSES = "does not answer", "not up yet", "late by the INS", "no sign of life", "waits for a disk"


class Run(msgspec.Struct):
    """What was seen of the mission."""

    record: RunRecord
    log: str


@pytest.fixture(scope="module")
def run() -> Iterator[Run]:
    spin = [sys.executable, "-c", "while True: pass"]
    rivals = [subprocess.Popen(spin) for _ in range(RIVALS * len(os.sched_getaffinity(0)))]
    try:
        with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
            bus = BusSettings(run_dir=Path(folder) / "run")
            settings = load(CONFIG, BenchConfig)
            settings = msgspec.structs.replace(settings, bus=bus, out=Path(folder) / "out", seconds=SECONDS)
            record = runner.fly_mission(settings)
            yield Run(record, (settings.out / "run.log").read_text())
    finally:
        for rival in rivals:
            rival.kill()
            rival.wait()


@pytest.mark.timeout(600)
def test_no_process_is_killed(run: Run) -> None:
    assert "killed" not in run.log
    assert all(len({report.pid for report in reports}) == 1 for reports in run.record.health.values())


def test_no_disk_ins_or_process_is_blamed(run: Run) -> None:
    told = {reason for _, item in run.record.lists for reason in item.reasons}
    told |= {problem for reports in run.record.health.values() for each in reports for problem in each.problems}
    assert not [text for text in told if any(words in text for words in WRONG_CAUSES)]


def test_each_list_says_the_one_cause_first_and_once(run: Run) -> None:
    named = [item.reasons for _, item in run.record.lists if any(OVERLOADED in reason for reason in item.reasons)]
    assert all(OVERLOADED in reasons[0] for reasons in named)
    assert all(sum(OVERLOADED in reason for reason in reasons) == 1 for reasons in named)


def test_ids_are_small(run: Run) -> None:
    ids = {obstacle.id for _, item in run.record.lists for obstacle in item.obstacles}
    assert ids
    assert max(ids) < 1000
