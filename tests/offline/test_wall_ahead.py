"""A wall that fills the fan, from the simulator to the planner's list: its echo is cut off on both sides."""

import math

import msgspec
import pytest

from ods.assess.sea.kind_run import reported_poses
from ods.assess.sea.run import images_of, scene_with_seed
from ods.base.clock import NS
from ods.base.files.shipped import shipped_file
from ods.offline.mission import Mission, MissionSettings
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.scene.settings import Plane
from ods.sim_sonar.scene.timeline import Scene

AWAY_M, SECONDS, CONFIRMED_S = 9.0, 8.0, 3.0


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("bed", ["gentle", "slope"])
def test_a_wall_ahead_is_in_each_list_that_is_valid(bed: str, seed: int) -> None:
    """Seed 0: deviations of metres that counted anew in each image made the echoes clutter, and none was listed."""
    file = scene_with_seed(shipped_file(f"scenes/sea/{bed}.toml"), seed).file
    wall = Plane(
        name="wall", position_ned=(AWAY_M, 0.0, 20.0), normal_ned=(-1.0, 0.0, 0.0), width_m=70.0, height_m=12.0,
        surface=Surface(cd=0.3, cs=0.1, sigma_deg=15.0),
    )  # fmt: skip
    still = msgspec.structs.replace(file.vehicle, velocity_ned=(0.0, 0.0, 0.0))
    scene = Scene(msgspec.structs.replace(file, objects=[wall], vehicle=still))
    sonar = find_sonar("seabat6012")
    times = [round(k * sonar.ping_period_s * NS) for k in range(round(SECONDS / sonar.ping_period_s) + 2)]
    pings = (ping for ping, _ in images_of(scene, sonar, SECONDS))
    steps = list(Mission(MissionSettings()).steps(pings, reported_poses(scene, times, None, seed)))
    late = [step.list for step in steps if step.list.valid and step.list.t_ns > steps[0].list.t_ns + CONFIRMED_S * NS]
    assert len(late) > 20
    for listed in late:
        (north, east, _) = (0.0, 0.0, 0.0) if listed.pose is None else listed.pose.position_ned
        nearest = [
            math.hypot(o.position_ned[0] - north, o.position_ned[1] - east) - o.radius_m for o in listed.obstacles
        ]
        assert min(nearest, default=math.inf) < AWAY_M
