"""The planner as a process: real sockets, and a CAN bus of pseudo-terminals."""

import math
import tempfile
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from ods.planner.set_point_pdo import pdo_of
from ods.sim_sonar.ins.slcan_hub import SlcanHub
from tests.planner.lists import obstacle, pose
from tests.planner.played import ROOT, PlayedPlanner, played_planner

PDO = pdo_of(ROOT / "config" / "vehicle.eds", 6)


@pytest.fixture
def wired() -> Iterator[tuple[PlayedPlanner, can.BusABC]]:
    """The planner, and the vehicle's end of its CAN bus."""
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        near, far = Path(folder) / "can0", Path(folder) / "can0-far"
        with (
            SlcanHub([near, far]),
            can.Bus(str(far), "slcan", ignore_config=True, sleep_after_open=0.0) as bus,
            played_planner("slcan", str(near)) as running,
        ):
            yield running, bus


def on_can(bus: can.BusABC) -> list[tuple[float, float, float]]:
    """Return the set points that have come."""
    found = []
    while (message := bus.recv(0.05)) is not None:
        assert message.arbitration_id == 0x206
        decoded = PDO.decode(bytes(message.data))
        assert decoded is not None
        found.append(decoded)
    return found


def test_set_points_follow_lists_on_both_buses(wired: tuple[PlayedPlanner, can.BusABC]) -> None:
    running, bus = wired
    running.until(lambda: bool(running.set_points) and running.set_points[-1].speed_m_s == 2.0)
    ahead = running.newest()
    assert (ahead.valid, ahead.avoiding, ahead.arrived, ahead.down_m) == (True, False, False, 20.0)
    assert math.remainder(ahead.heading_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-6)
    running.obstacles = [obstacle(40.0, 2.0)]
    running.until(lambda: running.set_points[-1].avoiding)
    running.until(lambda: 0.0 < -running.set_points[-1].heading_rad < math.radians(40.0))
    sent = on_can(bus)
    published = [(each.heading_rad % (2.0 * math.pi), each.speed_m_s, each.down_m) for each in running.set_points]
    assert any(sent[-1] == pytest.approx(each, abs=1e-3) for each in published)
    assert [each.seq for each in running.set_points] == sorted(each.seq for each in running.set_points)


def test_without_a_valid_list_it_goes_slowly_then_climbs_and_says_why(
    wired: tuple[PlayedPlanner, can.BusABC],
) -> None:
    running, bus = wired
    running.until(lambda: bool(running.set_points) and running.set_points[-1].speed_m_s == 2.0)
    running.valid = False
    running.until(lambda: not running.set_points[-1].valid)
    assert running.set_points[-1].speed_m_s == 1.0
    running.until(lambda: running.set_points[-1].down_m == 5.0)
    running.until(lambda: running.says("the list is not valid"))
    running.valid = True
    running.until(lambda: running.set_points[-1].down_m == 20.0 and running.set_points[-1].valid)
    on_can(bus)  # what has come, as a socket's buffer holds some 300 frames and then drops the newest
    running.published = False
    running.until(lambda: running.set_points[-1].down_m == 5.0)
    running.until(lambda: running.says("no obstacle list for"))
    assert on_can(bus)[-1] == pytest.approx((running.set_points[-1].heading_rad % (2.0 * math.pi), 1.0, 5.0), abs=1e-3)


def test_it_is_silent_until_it_knows_where_it_is_and_on_can_once_it_has_arrived(
    wired: tuple[PlayedPlanner, can.BusABC],
) -> None:
    running, bus = wired
    running.here = None
    running.until(lambda: running.says("the vehicle's pose is not known"))
    assert (running.set_points, on_can(bus)) == ([], [])
    running.here = pose(165.0, 0.0)
    running.until(lambda: bool(running.set_points) and running.set_points[-1].arrived)
    running.newest()
    assert on_can(bus) == []


def test_without_way_points_it_ends_with_one_line(capfd: pytest.CaptureFixture[str]) -> None:
    from ods.cli import main

    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        config = Path(folder) / "bench.toml"
        config.write_text((ROOT / "config" / "bench.toml").read_text().replace("/tmp/ods-bench", folder))
        assert main(["planner", "--config", str(config)]) == 2
    assert capfd.readouterr().err == "ods planner: planner: missing: set `way_points`, the vehicle's route\n"
