"""Range images of scenes, by the simulator's rays, as pings."""

from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from ods.base.arrays import Floats32
from ods.base.clock import NS
from ods.messages import Ping, Pose, RangeGrid
from ods.sim_sonar.range_image import RangeSonar, range_image
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sonar_link.ping_builder import Geometry, Stamp, build_range_ping, make_beam_table

SCENE = Path(__file__).parents[1] / "config" / "scenes" / "sonar3d15.toml"
SURFACE = {"cd": 0.1, "cs": 0.05, "sigma_deg": 15.0}
SONAR = RangeSonar(np.radians(np.linspace(-45.0, 45.0, 256)), np.radians(np.linspace(-20.0, 20.0, 64)), 15.0)
SCALE_M = 0.001
PERIOD_S = 0.167


def shipped_scene() -> Scene:
    """The scene of the bench."""
    return load_scene(SCENE)


def scene_of(
    *objects: dict[str, Any], bed_m: float | None = 22.6, velocity: tuple[float, ...] = (0.0, 0.0, 0.0)
) -> Scene:
    """A scene before a vehicle at a depth of 20 m."""
    reported: dict[str, Any] = {
        "seed": 1, "duration_s": 60.0, "shadows": False,
        "vehicle": {"position_ned": [0.0, 0.0, 20.0], "velocity_ned": list(velocity)},
        "objects": [{"name": f"{k}", "surface": SURFACE} | each for k, each in enumerate(objects)],
        "image": {"gain": 20000.0, "noise_counts": 30.0, "looks": 1.0},
    }  # fmt: skip
    if bed_m is not None:
        reported["sea_bed"] = {"depth_m": bed_m, "surface": SURFACE}
    return Scene(msgspec.convert(reported, SceneFile))


def sphere(north: float, east: float, down: float, radius_m: float = 0.5) -> dict[str, Any]:
    return {"shape": "sphere", "position_ned": [north, east, down], "radius_m": radius_m}


def ping_of(ranges: Floats32, number: int = 0, t_s: float = 0.0) -> Ping:
    """The ping of (rows, columns) ranges, m."""
    table = make_beam_table(SONAR.bearing_rad, np.zeros(SONAR.bearing_rad.size))
    geometry = Geometry(table, 0.0, SCALE_M, 1500.0)
    t_ns = round(t_s * NS)
    grid = RangeGrid(SONAR.elevation_rad.tolist(), SONAR.range_max_m)
    frame = np.rint(ranges / SCALE_M).astype(np.uint16).T
    return build_range_ping(frame, geometry, Stamp(number, number, t_ns, t_ns, t_ns), grid)


def pings_of(scene: Scene, count: int) -> list[Ping]:
    """One after the other."""
    return [ping_of(range_image(SONAR, scene, k * PERIOD_S, k), k, k * PERIOD_S) for k in range(count)]


def poses_of(scene: Scene, seconds: float) -> list[Pose]:
    """The vehicle's, 50 a second."""
    return [pose_at(scene, k * 0.02, k) for k in range(round(50.0 * seconds) + 10)]


def pose_at(scene: Scene, t_s: float, seq: int = 0) -> Pose:
    state = scene.vehicle_at(t_s)
    t_ns = round(t_s * NS)
    return Pose(
        seq, t_ns, t_ns, tuple(state.position_ned.tolist()), tuple(state.attitude.tolist()),
        tuple(state.velocity_body.tolist()), (0.05, 0.05, 0.05), (0.002, 0.002, 0.004),
    )  # fmt: skip
