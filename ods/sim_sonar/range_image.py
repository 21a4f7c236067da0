"""Range image of a scene by a 3-D sonar: the range of the first surface in each direction."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32
from ods.base.frames.geometry import polar_to_body, rotation_matrix
from ods.compiled import native
from ods.messages import Ping, RangeGrid
from ods.sim_sonar.echo.bodies.bodies import BODY, PLANE, UNBOUNDED, Bodies
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.model import SonarModel

STEPS = 2**14
"""Of a range in a ping, up to the farthest."""


class RangeSonar(NamedTuple):
    """A 3-D sonar and what its pixels are like."""

    bearing_rad: Floats
    """(columns,) positive to starboard."""
    elevation_rad: Floats
    """(rows,) up, the lowest first."""
    range_max_m: float
    noise_m: float = 0.01
    """Standard deviation of a range."""
    missing: float = 0.25
    """Share of pixels without an echo where there is an object."""
    false: float = 0.002
    """Share of pixels with a false echo, by noise."""


def range_sonar(model: SonarModel) -> RangeSonar:
    """Return the 3-D sonar of a file that has `pixels`. Raises ValueError for another."""
    if model.pixels is None:
        raise ValueError(f"sonar: {model.name} sends no range images: it has no pixels")
    columns, rows = model.pixels
    across = 0.5 * float(model.bearing_rad[-1] - model.bearing_rad[0])
    up = model.half_vertical_rad
    return RangeSonar(np.linspace(-across, across, columns), np.linspace(-up, up, rows), model.range_max_m)


class RangeImages:
    """The range images of one scene as pings: what `ImageSimulator` is to a sonar that sends levels."""

    def __init__(self, model: SonarModel, scene: Scene) -> None:
        """Raises ValueError for a scene with a rough sea-bed, and a sonar without `pixels`."""
        self._sonar, self._scene = range_sonar(model), scene
        self._geometry = {
            "beams": len(self._sonar.bearing_rad),
            "samples": len(self._sonar.elevation_rad),
            "bearing_rad": self._sonar.bearing_rad.tolist(),
            "range0_m": 0.0,
            "dr_m": model.range_max_m / STEPS,
            "sound_speed": model.sound_speed,
            "frequency_hz": model.frequency_hz,
            "range_grid": RangeGrid(self._sonar.elevation_rad.tolist(), model.range_max_m),
        }
        _bed_of(scene)

    def ping(self, t_s: float, ping_number: int, t_ns: int, utc_ns: int) -> Ping:
        """Return the image at scene time `t_s` as the sonar sends it, transmitted at `t_ns`."""
        ranges_m = range_image(self._sonar, self._scene, t_s, ping_number)
        frame = np.rint(ranges_m.T * (STEPS / self._sonar.range_max_m)).astype("<u2")
        return Ping(
            seq=ping_number,
            ping_number=ping_number,
            t_ns=t_ns,
            t_rx_ns=t_ns,
            utc_ns=utc_ns,
            dtype="u2",
            data=frame.tobytes(),
            **self._geometry,
        )


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
        raise ValueError("sea_bed: a 3-D sonar needs an even sea-bed")
    body = np.zeros(1, BODY)
    body["kind"], body["half"] = PLANE, (UNBOUNDED, UNBOUNDED, 0.0)
    body["axes"], body["centre"] = bed.axes.T, (0.0, 0.0, bed.depth_m)
    return body
