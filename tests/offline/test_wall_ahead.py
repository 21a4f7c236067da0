"""Walls from the simulator to the planner's list: their echoes fill the fan, or are longer than one circle may be."""

import math

import msgspec
import pytest

from ods.assess.sea.kind_run import reported_poses
from ods.assess.sea.run import images_of, scene_with_seed
from ods.base.clock import NS
from ods.base.files.shipped import shipped_file
from ods.messages import ObstacleList
from ods.offline.mission import Mission, MissionSettings
from ods.pipeline.measure.pieces import SIDE_M
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.scene.settings import Plane, VehiclePath
from ods.sim_sonar.scene.timeline import Scene

AWAY_M, SECONDS, CONFIRMED_S = 9.0, 8.0, 3.0
CORRIDOR_M, END_M, BED_DOWN_M = 12.0, 25.0, 25.0
STONE = Surface(cd=0.3, cs=0.1, sigma_deg=15.0)


def smooth_wall(name: str, north: float, east: float, facing: tuple[float, float], width_m: float) -> Plane:
    """Return a wall of 16 m height at the vehicle's depth."""
    return Plane(
        name=name, position_ned=(north, east, 20.0), normal_ned=(*facing, 0.0), width_m=width_m, height_m=16.0,
        surface=STONE,
    )  # fmt: skip


def lists_of(scene: Scene, seconds: float, seed: int = 0) -> list[ObstacleList]:
    """Return the lists of a scene that the SeaBat sees, in order."""
    sonar = find_sonar("seabat6012")
    times = [round(k * sonar.ping_period_s * NS) for k in range(round(seconds / sonar.ping_period_s) + 2)]
    pings = (ping for ping, _ in images_of(scene, sonar, seconds))
    return [step.list for step in Mission(MissionSettings()).steps(pings, reported_poses(scene, times, None, seed))]


def nearest_m(listed: ObstacleList) -> float:
    """Return the horizontal distance to the edge of the nearest circle."""
    (north, east, _) = (0.0, 0.0, 0.0) if listed.pose is None else listed.pose.position_ned
    edges = (math.hypot(o.position_ned[0] - north, o.position_ned[1] - east) - o.radius_m for o in listed.obstacles)
    return min(edges, default=math.inf)


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("bed", ["gentle", "slope"])
def test_a_wall_ahead_is_in_each_list_that_is_valid(bed: str, seed: int) -> None:
    """Seed 0: deviations of metres that counted anew in each image made the echoes clutter, and none was listed."""
    file = scene_with_seed(shipped_file(f"scenes/sea/{bed}.toml"), seed).file
    wall = Plane(
        name="wall", position_ned=(AWAY_M, 0.0, 20.0), normal_ned=(-1.0, 0.0, 0.0), width_m=70.0, height_m=12.0,
        surface=STONE,
    )  # fmt: skip
    still = msgspec.structs.replace(file.vehicle, velocity_ned=(0.0, 0.0, 0.0))
    lists = lists_of(Scene(msgspec.structs.replace(file, objects=[wall], vehicle=still)), SECONDS, seed)
    late = [each for each in lists if each.valid and each.t_ns > lists[0].t_ns + CONFIRMED_S * NS]
    assert len(late) > 20
    assert all(nearest_m(each) < AWAY_M for each in late)


def test_the_walls_of_a_corridor_and_its_end_are_in_each_list_that_is_valid() -> None:
    """No list had any of the three before the vehicle was 4 m before the end: they are larger than any clutter."""
    file = scene_with_seed(shipped_file("scenes/sea/gentle.toml"), 0).file
    aside = 0.5 * CORRIDOR_M
    walls = [
        smooth_wall("port", 40.0, -aside, (0.0, 1.0), 100.0),
        smooth_wall("starboard", 40.0, aside, (0.0, -1.0), 100.0),
        smooth_wall("end", END_M, 0.0, (-1.0, 0.0), CORRIDOR_M),
    ]
    assert file.sea_bed is not None
    bed = msgspec.structs.replace(file.sea_bed, depth_m=BED_DOWN_M)
    ahead = VehiclePath(position_ned=(0.0, 0.0, 20.0), velocity_ned=(1.0, 0.0, 0.0))
    lists = lists_of(Scene(msgspec.structs.replace(file, objects=walls, vehicle=ahead, sea_bed=bed)), SECONDS)
    late = [each for each in lists if each.valid and each.t_ns > lists[0].t_ns + CONFIRMED_S * NS]
    assert len(late) > 20
    assert all(nearest_m(each) < aside / math.sin(math.radians(44.0)) for each in late)


@pytest.mark.parametrize(("aslant_deg", "away_m"), [(0.0, 40.0), (-30.0, 45.0), (60.0, 35.0)])
def test_the_nearest_point_of_a_wall_is_covered_and_what_lies_before_it_is_free(
    aslant_deg: float, away_m: float
) -> None:
    """One circle had all of the wall: it reached far before it, and not to its near end where it stood aslant."""
    file = scene_with_seed(shipped_file("scenes/sea/gentle.toml"), 0).file
    turn = math.radians(180.0 + aslant_deg)
    wall = smooth_wall("wall", away_m, 3.0, (math.cos(turn), math.sin(turn)), 24.0)
    ahead = VehiclePath(position_ned=(0.0, 0.0, 20.0), velocity_ned=(1.0, 0.0, 0.0))
    lists = lists_of(Scene(msgspec.structs.replace(file, objects=[wall], vehicle=ahead)), SECONDS)
    late = [each for each in lists if each.valid and each.t_ns > lists[0].t_ns + CONFIRMED_S * NS]
    assert len(late) > 20
    steps = [0.25 * k - 12.0 for k in range(97)]
    places = [(away_m - step * math.sin(turn), 3.0 + step * math.cos(turn)) for step in steps]
    for each in late:
        assert each.pose is not None
        north, east, _ = each.pose.position_ned
        from_m, place = min((math.hypot(n - north, e - east), (n, e)) for n, e in places)
        assert from_m - nearest_m(each) < SIDE_M
        edges = [math.dist(place, o.position_ned[:2]) - o.radius_m for o in each.obstacles]
        assert min(edges) < 1.0
