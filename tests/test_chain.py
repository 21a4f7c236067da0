"""The whole chain, every process, on a pty and a CAN bus, with the faults of config/bench-faults.toml."""

import tempfile
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest

from ods.bench import runner
from ods.bench.collector import Record
from ods.bench.metrics import Summary, summarize
from ods.bench.settings import BenchConfig
from ods.clock import NS
from ods.config import BusSettings
from ods.messages import ObstacleList
from ods.settings_file import load

CONFIG = Path(__file__).parents[1] / "config" / "bench-faults.toml"


@pytest.fixture(scope="module")
def settings() -> Iterator[BenchConfig]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        shipped = load(CONFIG, BenchConfig)
        bus = BusSettings(run_dir=Path(folder) / "run")
        yield msgspec.structs.replace(shipped, bus=bus, out=Path(folder) / "out")


@pytest.fixture(scope="module")
def record(settings: BenchConfig) -> Record:
    return runner.run(settings)


@pytest.fixture(scope="module")
def summary(record: Record, settings: BenchConfig) -> Summary:
    return summarize(record, settings.limits, settings.settle_s)


def lists_between(record: Record, settings: BenchConfig, begin_s: float, end_s: float) -> list[ObstacleList]:
    """Return the lists that arrived in a span of mission time."""
    start_ns = min(truth.t_ns for truth in record.truths.values())
    return [item for at, item in record.lists if begin_s <= (at - start_ns) / NS < end_s]


@pytest.mark.timeout(300)
@pytest.mark.parametrize("process", ["sonar", "pipeline", "nav", "tracker"])
def test_kill_9_back_within_3_s(summary: Summary, process: str) -> None:
    assert summary.back_s[process] < 3.0


def test_tracks_survive_a_restart_of_any_process_but_the_tracker(record: Record, settings: BenchConfig) -> None:
    before = {item.id for item in lists_between(record, settings, 7.0, 8.0)[-1].obstacles}
    after = {item.id for item in lists_between(record, settings, 30.0, 32.0)[-1].obstacles}
    assert len(before) == 3
    assert before == after


def test_the_hibernated_map_survives_a_restart_of_the_tracker(record: Record, settings: BenchConfig) -> None:
    def hibernated(begin_s: float, end_s: float) -> list[set[int]]:
        lists = lists_between(record, settings, begin_s, end_s)
        return [{item.id for item in one.obstacles if item.state == "hibernated"} for one in lists]

    before, after = hibernated(30.0, 32.0)[-1], hibernated(36.0, 40.0)[-1]
    assert before
    assert before <= after


def test_a_pulled_serial_line_is_said_counted_and_recovered(record: Record, settings: BenchConfig) -> None:
    during = lists_between(record, settings, 23.2, 24.0)
    assert during
    assert not any(item.valid for item in during)
    assert any("no ping for" in reason for reason in during[-1].reasons)
    assert all(item.valid for item in lists_between(record, settings, 26.0, 27.0))
    assert record.health["sonar"][-1].counters["port_losses"] >= 1


def test_a_silent_ins_is_said_and_recovered(record: Record, settings: BenchConfig) -> None:
    during = lists_between(record, settings, 28.0, 28.4)
    assert any("no pose for" in reason for item in during for reason in item.reasons)
    assert all(item.valid for item in lists_between(record, settings, 30.5, 31.5))


def test_the_list_never_goes_quiet_but_while_the_tracker_is_away(record: Record, settings: BenchConfig) -> None:
    arrivals = [at for at, _ in record.lists]
    start_ns = min(truth.t_ns for truth in record.truths.values())
    gaps = [(later - earlier) / NS for earlier, later in pairwise(arrivals) if (later - start_ns) / NS < 32.0]
    assert max(gaps) < 1.0


def test_limits_hold(summary: Summary) -> None:
    assert not [line for line in summary.broken if not line.startswith("latency")]
