"""Scenes of the simulator as scenarios: positions without images; detections are drawn as in all scenarios."""

from pathlib import Path

import numpy as np

from ods.assess.track.case import World
from ods.assess.track.scenarios import SONAR, Kind, Limits, clock
from ods.base.errors import OdsError
from ods.base.frames.geometry import euler_from_quat
from ods.sim_sonar.scene.timeline import Scene, load_scene


def scene_kind(file: Path) -> Kind:
    """Return a scene file's scenario, without limits. Raises OdsError."""
    scene = load_scene(file)
    if not scene.shown:
        raise OdsError(f"--scene {file}: there is no object to track")
    return Kind(lambda _rng: world_of(scene), Limits(switches=None))


def world_of(scene: Scene) -> World:
    """Return vehicle and bounded objects, 7 scans a second; roll and pitch are left out.

    Objects are the circles that circumscribe them. Nothing but the sector keeps them from being seen.
    """
    t = clock(scene.file.duration_s)
    pose = scene.pose_at(t)
    _, _, yaw = euler_from_quat(pose.attitude)
    states = [scene.objects_at(float(t_s)) for t_s in t]
    truth = np.stack([np.column_stack([each.position_ned, each.velocity_ned, each.radius_m]) for each in states])
    shape = truth.shape[:2]
    return World(
        t, pose.position_ned, np.unwrap(yaw), truth, SONAR, np.ones(shape, bool), np.ones(shape), np.zeros((len(t), 5))
    )
