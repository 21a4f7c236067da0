"""The whole chain with a simulated Ping360 behind datagrams: objects are found as the sector fills, sweep by sweep."""

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

CONFIG = Path(__file__).parents[2] / "config" / "bench-ping360.toml"


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        port: int = one.getsockname()[1]
        return port


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_every_object_has_a_track_after_four_sweeps_and_the_list_says_when_it_is_valid() -> None:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        shipped = load(CONFIG, BenchConfig)
        sim = msgspec.structs.replace(shipped.sim, sonar_line="ping360_udp", sonar_udp_port=free_port())
        bus = BusSettings(run_dir=Path(folder) / "run")
        record = runner.fly_mission(
            msgspec.structs.replace(shipped, bus=bus, out=Path(folder) / "out", sim=sim, seconds=55.0)
        )
    lists = [item for _, item in record.lists]
    first = next(item for item in lists if item.sector is not None)
    valid = next(item for item in lists if item.valid)
    assert 30.0 < (valid.t_ns - first.t_ns) / 1e9 < 45.0
    last = [item for item in lists if item.valid and item.ping_number in record.truths][-1]
    things = [item for item in record.truths[last.ping_number].objects if item.in_sector]
    assert len(things) == 3
    for thing in things:
        assert any(math.dist(item.position_ned[:2], thing.position_ned[:2]) < 1.0 for item in last.obstacles)
    assert any(part.why == "not swept" for part in last.unseen)
    assert record.image is not None
    ping, found = record.image
    assert ping.sweep is not None
    assert found.turn_s == pytest.approx(9.0, abs=0.7)
    counters = record.health["sonar"][-1].counters
    assert counters["beams"] > 400
    assert not counters.keys() & {"control_lost", "control_refused", "bad_ping", "bad_checksum", "garbage_bytes"}
