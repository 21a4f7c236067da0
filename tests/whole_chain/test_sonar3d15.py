"""The whole chain with a simulated Sonar 3D-15: range images by multicast, heights in the list."""

import math
import tempfile
from pathlib import Path

import msgspec
import pytest

from ods.base.settings_file import load
from ods.bench import runner
from ods.bench.settings import BenchConfig
from ods.runtime.bus import BusSettings
from tests.sonar_link.sonar3d15.test_live import free_port

CONFIG = Path(__file__).parents[2] / "config" / "bench-sonar3d15.toml"


@pytest.mark.timeout(300)
def test_every_object_has_a_track_with_its_height() -> None:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        shipped = load(CONFIG, BenchConfig)
        sim = msgspec.structs.replace(shipped.sim, sonar_udp_port=free_port())
        bus = BusSettings(run_dir=Path(folder) / "run")
        record = runner.fly_mission(
            msgspec.structs.replace(shipped, bus=bus, out=Path(folder) / "out", sim=sim, seconds=10.0)
        )
    last = [item for _, item in record.lists if item.valid and item.ping_number in record.truths][-1]
    things = record.truths[last.ping_number].objects
    assert len(things) == len(last.obstacles) == 3
    for thing in things:
        near = min(last.obstacles, key=lambda item: math.dist(item.position_ned, thing.position_ned))
        assert math.dist(near.position_ned, thing.position_ned) < 0.35
        assert near.sigma_position[2] < 0.4
    assert record.image is not None
    ping, _ = record.image
    assert ping.range_grid is not None
    assert (ping.beams, ping.samples, ping.range_grid.range_max_m) == (256, 64, 15.0)
    counters = record.health["sonar"][-1].counters
    assert not counters.keys() & {"bad_ping", "bad_checksum", "no_device_time", "stranger_datagrams"}
