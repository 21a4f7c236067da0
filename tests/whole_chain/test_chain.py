"""The whole chain, every process: on a pty and a CAN bus with the faults of config/bench-faults.toml; and over TCP."""

import socket
import tempfile
import threading
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import msgspec
import pytest
import zmq

from ods.base.clock import NS
from ods.base.settings_file import load
from ods.bench import runner
from ods.bench.metrics import Summary, summarize
from ods.bench.settings import BenchConfig
from ods.client import Sonar
from ods.messages import ObstacleList, Ping
from ods.offline.run_record import RunRecord
from ods.runtime import bus
from ods.runtime.bus import BusSettings

CONFIG = Path(__file__).parents[2] / "config" / "bench-faults.toml"
CALM_CONFIG = CONFIG.with_name("bench.toml")


@pytest.fixture(scope="module")
def settings() -> Iterator[BenchConfig]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        shipped = load(CONFIG, BenchConfig)
        bus = BusSettings(run_dir=Path(folder) / "run")
        yield msgspec.structs.replace(shipped, bus=bus, out=Path(folder) / "out")


@pytest.fixture(scope="module")
def record(settings: BenchConfig) -> RunRecord:
    return runner.fly_mission(settings)


@pytest.fixture(scope="module")
def summary(record: RunRecord, settings: BenchConfig) -> Summary:
    return summarize(record, settings.limits, settings.settle_s)


def lists_between(record: RunRecord, settings: BenchConfig, begin_s: float, end_s: float) -> list[ObstacleList]:
    """Return the lists that arrived in a span of mission time."""
    start_ns = min(truth.t_ns for truth in record.truths.values())
    return [item for at, item in record.lists if begin_s <= (at - start_ns) / NS < end_s]


@pytest.mark.timeout(300)
@pytest.mark.parametrize("process", ["sonar", "pipeline", "nav", "tracker"])
def test_kill_9_back_within_3_s(summary: Summary, process: str) -> None:
    assert summary.back_s[process] < 3.0


def test_tracks_survive_a_restart_of_any_process_but_the_tracker(record: RunRecord, settings: BenchConfig) -> None:
    before = {item.id for item in lists_between(record, settings, 7.0, 8.0)[-1].obstacles}
    after = {item.id for item in lists_between(record, settings, 30.0, 32.0)[-1].obstacles}
    assert len(before) == 3
    assert before == after


def test_the_hibernated_map_survives_a_restart_of_the_tracker(record: RunRecord, settings: BenchConfig) -> None:
    def hibernated(begin_s: float, end_s: float) -> list[set[int]]:
        lists = lists_between(record, settings, begin_s, end_s)
        return [{item.id for item in one.obstacles if item.state == "hibernated"} for one in lists]

    before, after = hibernated(30.0, 32.0)[-1], hibernated(36.0, 40.0)[-1]
    assert before
    assert before <= after


def test_a_pulled_serial_line_is_said_counted_and_recovered(record: RunRecord, settings: BenchConfig) -> None:
    during = lists_between(record, settings, 23.2, 24.0)
    assert during
    assert not any(item.valid for item in during)
    assert any("no ping for" in reason for reason in during[-1].reasons)
    assert all(item.valid for item in lists_between(record, settings, 26.0, 27.0))
    assert record.health["sonar"][-1].counters["port_losses"] >= 1


def test_a_silent_ins_is_said_and_recovered(record: RunRecord, settings: BenchConfig) -> None:
    during = lists_between(record, settings, 28.0, 28.4)
    assert any("no pose for" in reason for item in during for reason in item.reasons)
    assert all(item.valid for item in lists_between(record, settings, 30.5, 31.5))


def test_the_list_never_goes_quiet_but_while_the_tracker_is_away(record: RunRecord, settings: BenchConfig) -> None:
    arrivals = [at for at, _ in record.lists]
    start_ns = min(truth.t_ns for truth in record.truths.values())
    gaps = [(later - earlier) / NS for earlier, later in pairwise(arrivals) if (later - start_ns) / NS < 32.0]
    assert max(gaps) < 1.0


def test_limits_hold(summary: Summary) -> None:
    assert not [line for line in summary.broken if not line.startswith("latency")]


class Planner(threading.Thread):
    """Sets the sonar's range in mid-mission, and keeps the pings that come before and after."""

    def __init__(self, run_dir: Path, at_ping: int, range_m: float) -> None:
        super().__init__(daemon=True)
        self.pings: list[Ping] = []
        self.done = threading.Event()
        self._run_dir, self._at_ping, self._range_m = run_dir, at_ping, range_m

    def run(self) -> None:
        context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        with bus.Subscriber(context, self._run_dir, ["ping"]) as subscriber:
            self._collect(subscriber, until=lambda: len(self.pings) >= self._at_ping)
            sonar = Sonar(self._run_dir)
            sonar.set_range(self._range_m)
            sonar.close()
            self._collect(subscriber, until=self.done.is_set)
        context.term()

    def _collect(self, subscriber: bus.Subscriber, until: Callable[[], bool]) -> None:
        while not self.done.is_set():
            self.pings += [ping for _, ping in subscriber.receive(0.1)[0]]
            if until():
                break


def free_tcp_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


@pytest.mark.timeout(300)
def test_over_tcp_a_planner_halves_the_range_in_mid_mission_and_nothing_is_lost() -> None:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        shipped = load(CALM_CONFIG, BenchConfig)
        sim = msgspec.structs.replace(shipped.sim, sonar_line="tcp", sonar_tcp_port=free_tcp_port())
        run_dir = Path(folder) / "run"
        settings = msgspec.structs.replace(
            shipped, bus=BusSettings(run_dir=run_dir), out=Path(folder) / "out", sim=sim, seconds=14.0
        )
        planner = Planner(run_dir, at_ping=40, range_m=50.0)
        planner.start()
        record = runner.fly_mission(settings)
        planner.done.set()
        planner.join(10.0)
    listed = {item.ping_number: item for _, item in record.lists}
    last_whole = min(max(listed), max(record.truths))  # the end may cut off the last list, or its truth
    pings = [ping for ping in planner.pings if ping.ping_number <= last_whole]
    numbers = [ping.ping_number for ping in pings]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    samples = [ping.samples for ping in pings]
    before = samples.index(1000)
    assert samples == [2000] * before + [1000] * (len(samples) - before)
    assert before >= 40
    assert set(numbers) <= listed.keys()
    assert not {number for number in record.truths if number <= max(listed)} - listed.keys()
    last = listed[numbers[-1]]
    near = [o for o in record.truths[numbers[-1]].objects if o.in_sector]
    assert last.valid
    assert near
    for thing in near:
        assert any(
            abs(o.position_ned[0] - thing.position_ned[0]) + abs(o.position_ned[1] - thing.position_ned[1]) < 3.0
            for o in last.obstacles
        )
    assert record.health["sonar"][-1].counters["network_frames"] > 0
    assert record.health["sonar"][-1].counters.get("unframed_bytes", 0) == 0
