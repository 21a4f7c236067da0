"""The whole chain with a simulated Oculus at the end of its own kind of TCP."""

import math
import socket
import tempfile
from pathlib import Path

import msgspec
import pytest

from ods.base.settings_file import load
from ods.bench import runner
from ods.bench.settings import BenchConfig
from ods.runtime.bus import BusSettings

CONFIG = Path(__file__).parents[2] / "config" / "bench-oculus.toml"


@pytest.mark.timeout(300)
def test_every_object_has_a_track_and_the_sonar_obeys() -> None:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder, socket.create_server(("127.0.0.1", 0)) as found:
        port = found.getsockname()[1]
        found.close()
        shipped = load(CONFIG, BenchConfig)
        sim = msgspec.structs.replace(shipped.sim, sonar_tcp_port=port)
        bus = BusSettings(run_dir=Path(folder) / "run")
        record = runner.fly_mission(
            msgspec.structs.replace(shipped, bus=bus, out=Path(folder) / "out", sim=sim, seconds=10.0)
        )
    last = [item for _, item in record.lists if item.valid and item.ping_number in record.truths][-1]
    things = [item for item in record.truths[last.ping_number].objects if item.in_sector]
    assert len(things) == 3
    for thing in things:
        assert any(math.dist(item.position_ned[:2], thing.position_ned[:2]) < 1.0 for item in last.obstacles)
    assert record.image is not None
    ping, _ = record.image
    assert (ping.beams, ping.samples, ping.dtype) == (512, 1000, "f4")  # 40 m, gamma undone
    assert ping.sound_speed == 1500.0
    counters = record.health["sonar"][-1].counters
    assert counters["control_requests"] >= 1
    assert not counters.keys() & {"control_lost", "bad_ping", "garbage_bytes", "no_device_time", "duplicate_pings"}
