"""How a steered vehicle came through, by numbers by hand."""

import math
from itertools import count
from pathlib import Path

import msgspec
import pytest

from ods.base.clock import NS
from ods.base.settings_file import ConfigError, load
from ods.bench.settings import AvoidLimits, BenchConfig
from ods.bench.way.avoidance import Avoidance, Mission, judge, missed
from ods.bench.way.best_path import best_path, length_m
from ods.messages import VehicleSetPoint, VehicleTruth
from ods.planner.settings import SteeringSettings
from ods.sim_sonar.scene.settings import Cylinder, SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sea_bed.settings import SeaBed
from ods.sim_sonar.settings import VehicleSettings
from ods.sim_sonar.steered import SteeredVehicle, at_start

CONFIG = Path(__file__).parents[2] / "config"
LIMITS = AvoidLimits(clearance_m=1.0, over_bottom_m=5.0, path_ratio=1.15)
GOOD = Avoidance(True, 2.0, "pile", 7.0, 100.0, 1.1, 1.1, 50.0, 3, 1.0, 0.0)


def mission(*objects: Cylinder | Sphere) -> Mission:
    file = SceneFile(
        seed=1,
        vehicle=VehiclePath(position_ned=(0.0, 0.0, 20.0)),
        objects=list(objects),
        sea_bed=SeaBed(depth_m=27.0),
    )
    can = VehicleSettings(radius_m=0.5)
    scene = Scene(file, vehicle=SteeredVehicle(can, at_start(0.0, 0.0)))
    return Mission(scene, [(100.0, 0.0, 20.0)], SteeringSettings(reached_m=10.0), can, (0.0, 0.0), 1.0)


PILE = Cylinder(name="pile", position_ned=(50.0, 4.0, 20.0), radius_m=1.0, length_m=20.0)
MOVER = Sphere(name="mover", position_ned=(50.0, -30.0, 20.0), velocity_ned=(0.0, 1.0, 0.0), radius_m=2.0)
"""Abreast of the way at 30 s."""


def straight(until_s: float, *, speed: float = 2.0, down: float = 20.0, step_s: float = 0.5) -> list[VehicleTruth]:
    found: list[VehicleTruth] = []
    for seq in count():
        t_s = seq * step_s
        if t_s > until_s:
            return found
        attitude = (1.0, 0.0, 0.0, 0.0)
        stopped = 5.0 <= t_s < 7.0
        place = (speed * t_s, 0.0, down)
        found.append(VehicleTruth(seq, round(t_s * NS), t_s, place, attitude, (speed, 0.0, 0.0), stopped))
    return found


def said(at_s: float, *, avoiding: bool = False, valid: bool = True, arrived: bool = False) -> VehicleSetPoint:
    t_ns = round(at_s * NS)
    return VehicleSetPoint(0, t_ns, t_ns, 0.0, 2.0, 20.0, 0, avoiding, valid, arrived)


def test_it_came_as_near_as_the_circles_do() -> None:
    """4 m abeam, less 1 m of the pile and 0.5 m of its own."""
    found = judge(mission(PILE), straight(45.0), [said(45.0, arrived=True)], None)
    assert found.nearest == "pile"
    assert (found.clearance_m, found.over_bottom_m) == pytest.approx((2.5, 7.0))
    assert (found.path_m, found.straight_ratio, found.path_ratio) == pytest.approx((90.0, 1.0, 1.0))
    assert found.seconds == pytest.approx(45.0)


def test_what_moves_counts_where_it_is_then() -> None:
    """It crosses the way at 30 s, when a vehicle of 5/3 m/s is there, too."""
    found = judge(mission(PILE, MOVER), straight(40.0, speed=5.0 / 3.0), [], None)
    assert found.nearest == "mover"
    assert found.clearance_m == pytest.approx(-2.5)
    assert missed(found, LIMITS)["collision"] == "it collided with mover"


def test_over_the_top_of_a_pile_its_height_counts() -> None:
    """Its top is at 10 m; 4 m above it and 2.5 m beside its wall, with the vehicle's circle taken off."""
    found = judge(mission(PILE), straight(45.0, down=6.0), [], None)
    assert found.clearance_m == pytest.approx(math.hypot(3.0, 4.0) - 0.5)


def test_what_follows_the_arrival_does_not_count() -> None:
    late = [said(20.0, arrived=True), said(30.0, arrived=True)]
    found = judge(mission(PILE), straight(45.0), late, None)
    assert (found.arrived, found.seconds) == (True, 20.0)
    assert found.clearance_m == pytest.approx(math.hypot(10.0, 4.0) - 1.5)


def test_evasions_and_times_are_counted() -> None:
    reported = [said(0.0, valid=False), said(2.0), said(4.0, avoiding=True), said(5.0, avoiding=True)]
    reported += [said(6.0), said(7.0, avoiding=True), said(8.0, valid=False), said(8.5)]
    found = judge(mission(PILE), straight(45.0), reported, None)
    assert (found.evasions, found.arrived) == (2, False)
    assert (found.not_valid_s, found.stopped_s) == pytest.approx((2.5, 2.0))


@pytest.mark.parametrize(
    ("change", "broken"),
    [
        ({}, {}),
        ({"clearance_m": 0.9}, {"clearance_m": "clearance_m is 0.90 (pile), the limit is 1"}),
        ({"clearance_m": -0.1}, {"collision": "it collided with pile"}),
        ({"over_bottom_m": 4.0}, {"over_bottom_m": "over_bottom_m is 4.00, the limit is 5"}),
        ({"path_ratio": 1.2}, {"path_ratio": "path_ratio is 1.200, the limit is 1.15"}),
        ({"arrived": False, "path_ratio": 0.2}, {"arrived": "it did not arrive in 50 s"}),
        ({"clearance_m": math.nan}, {"clearance_m": "clearance_m is nan (pile), the limit is 1"}),
    ],
)
def test_each_limit_is_judged(change: dict[str, object], broken: dict[str, str]) -> None:
    assert missed(msgspec.structs.replace(GOOD, **change), LIMITS) == broken


@pytest.mark.parametrize(
    ("was", "is_", "said"),
    [
        ('[planner]\nway_points = [[170.0, 0.0, 20.0]]\n\n[planner.can]\neds = "vehicle.eds"', "", "planner: missing"),
        ('[sim.vehicle]\neds = "vehicle.eds"\ncurrent_m_s = [0.1, -0.15]', "", "sim.vehicle: missing"),
        ('[planner.can]\neds = "vehicle.eds"', "", "planner.can: missing"),
        ("[limits]", '[[kill]]\nprocess = "planner"\nat_s = 1.0\nsignal = "STOP"\n[limits]', "signal: the planner"),
        (
            "[planner]",
            "[planner.steering]\ncruise_m_s = 33.0\n[planner]",
            "planner.steering.cruise_m_s: at most 32 m/s",
        ),
    ],
)
def test_what_belongs_together_is_asked_for_in_one_line(tmp_path: Path, was: str, is_: str, said: str) -> None:
    shipped = (CONFIG / "bench-avoid.toml").read_text()
    assert was in shipped
    file = tmp_path / "bench.toml"
    file.write_text(shipped.replace(was, is_))
    with pytest.raises(ConfigError, match=said) as refused:
        load(file, BenchConfig)
    assert "\n" not in str(refused.value)


def test_its_way_is_measured_by_that_of_an_all_knowing_planner() -> None:
    """Which goes round a pile in its way, 1 m clear of it with a circle of 0.5 m."""
    blocked = mission(msgspec.structs.replace(PILE, position_ned=(50.0, 0.0, 20.0), radius_m=6.4))
    best = best_path(blocked, straight(0.0)[0])
    assert best is not None
    assert math.hypot(best[-1, 0] - 100.0, best[-1, 1]) <= 10.0
    assert 7.9 < min(math.hypot(north - 50.0, east) for north, east in best.tolist()) < 8.6
    assert 90.0 < length_m(best) < 94.0
    found = judge(blocked, straight(45.0), [], 100.0)
    assert (found.straight_ratio, found.path_ratio) == pytest.approx((1.0, 0.9))
