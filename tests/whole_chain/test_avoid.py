"""A planner steers the simulated vehicle, every process, with the faults of config/bench-avoid-faults.toml."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from ods.base.settings_file import load
from ods.bench import runner
from ods.bench.mission import steered_mission
from ods.bench.settings import BenchConfig
from ods.bench.way.avoidance import Avoidance, judge
from ods.offline.run_record import RunRecord
from ods.runtime.bus import BusSettings

CONFIG = Path(__file__).parents[2] / "config" / "bench-avoid-faults.toml"
pytestmark = pytest.mark.timeout(400)


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
def found(record: RunRecord, settings: BenchConfig) -> Avoidance:
    steered = steered_mission(settings)
    assert steered is not None
    return judge(steered, record.way, record.set_points, None)


def test_it_arrives_without_a_collision_whatever_fails(found: Avoidance) -> None:
    assert found.arrived
    assert found.clearance_m > 0.0
    assert found.over_bottom_m > 5.0


def test_while_the_sonar_is_silent_it_goes_slowly_and_climbs(record: RunRecord) -> None:
    """From 24 s to 29 s: not valid after 1 s, climbing after 3 s."""
    way = [each for each in record.way if 28.0 <= each.scene_s < 29.0]
    during = [each for each in record.set_points if way[0].t_ns <= each.t_ns <= way[-1].t_ns]
    assert {(each.valid, each.speed_m_s, each.down_m) for each in during} == {(False, 1.0, 5.0)}
    assert way[-1].position_ned[2] < 20.0


def test_the_vehicle_goes_by_what_came_over_can_and_stops_while_the_planner_is_dead(record: RunRecord) -> None:
    """It is killed at 50 s. The straight way is blocked at 38 m."""
    dead = [each.stopped for each in record.way if 49.0 <= each.scene_s < 60.0]
    assert not dead[0]
    assert any(dead)
    assert not dead[-1]
    assert max(abs(each.position_ned[1]) for each in record.way) > 3.0
