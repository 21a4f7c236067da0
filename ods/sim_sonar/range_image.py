"""What a 3-D sonar makes of a scene: the range of the first surface in each direction."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32
from ods.base.frames.geometry import polar_to_body, rotation_matrix
from ods.compiled import native
from ods.sim_sonar.echo.bodies import BODY, PLANE, UNBOUNDED, Bodies
from ods.sim_sonar.scene.timeline import Scene


class RangeSonar(NamedTuple):
    """A 3-D sonar and what its pixels are like."""

    bearing_rad: Floats
    """(columns,) to starboard,"""
    elevation_rad: Floats
    """(rows,) up, the lowest first."""
    range_max_m: float
    noise_m: float = 0.01
    """Standard deviation of a range."""
    missing: float = 0.25
    """Share of the pixels that show nothing, where something is:"""
    false: float = 0.002
    """and of those that show something anywhere, as noise does."""


def range_image(sonar: RangeSonar, scene: Scene, t_s: float, number: int) -> Floats32:
    """Return (rows, columns) ranges, m, of the image of that number at scene time `t_s`; 0: no echo.

    Raises ValueError for a scene with a rough sea-bed.
    """
    pose = scene.head_at(t_s)
    in_head = polar_to_body(1.0, sonar.bearing_rad[None, :], sonar.elevation_rad[:, None])
    rays = np.ascontiguousarray(in_head.reshape(-1, 3) @ rotation_matrix(pose.attitude).T)
    bodies = np.concatenate([scene.bodies_at(t_s), _bed_of(scene)])
    bodies["centre"] -= pose.position_ned
    exact = np.empty(len(rays))
    native.first_hits(bodies, rays, exact)
    rng = np.random.default_rng([scene.file.seed, number])
    seen = exact + sonar.noise_m * rng.standard_normal(len(rays))
    shown = (exact < sonar.range_max_m) & (rng.random(len(rays)) >= sonar.missing)
    false = rng.random(len(rays)) < sonar.false
    seen = np.where(false, sonar.range_max_m * rng.random(len(rays)), np.where(shown, seen, 0.0))
    return np.asarray(np.maximum(seen, 0.0).astype(np.float32).reshape(in_head.shape[:2]))


def _bed_of(scene: Scene) -> Bodies:
    bed = scene.sea_bed
    if bed is None:
        return np.empty(0, BODY)
    if bed.field is not None:
        raise ValueError("sea_bed: a 3-D sonar is simulated over even sea-beds only")
    body = np.zeros(1, BODY)
    body["kind"], body["half"] = PLANE, (UNBOUNDED, UNBOUNDED, 0.0)
    body["axes"], body["centre"] = bed.axes.T, (0.0, 0.0, bed.depth_m)
    return body
