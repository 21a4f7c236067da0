"""The whole chain with a navigation system that speaks NMEA 0183 and PD6, on a pseudo-terminal."""

import math
import tempfile
from pathlib import Path

import msgspec
import pytest

from ods.base.settings_file import load
from ods.bench import runner
from ods.bench.settings import BenchConfig
from ods.runtime.bus import BusSettings

CONFIG = Path(__file__).parents[2] / "config" / "bench-nmea.toml"


@pytest.mark.timeout(300)
def test_every_object_has_a_track_where_it_is() -> None:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        shipped = load(CONFIG, BenchConfig)
        bus = BusSettings(run_dir=Path(folder) / "run")
        record = runner.fly_mission(msgspec.structs.replace(shipped, bus=bus, out=Path(folder) / "out", seconds=8.0))
    last = [item for _, item in record.lists if item.valid and item.ping_number in record.truths][-1]
    things = [item for item in record.truths[last.ping_number].objects if item.in_sector]
    assert len(things) == 3
    for thing in things:
        assert any(math.dist(item.position_ned[:2], thing.position_ned[:2]) < 1.0 for item in last.obstacles)
    counters = record.health["nav"][-1].counters
    assert counters["poses"] > 400
    assert not counters.keys() & {"nmea_damaged", "nmea_not_valid", "line_overlong", "epoch_absurd"}
