"""The mean image of what surrounds a sonar: arrays in, one array out; no noise, no levels."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.sim_sonar.echo.bodies.bodies import Bodies, to_sonar_frame
from ods.sim_sonar.echo.bodies.shadow import SHADE, add_shades
from ods.sim_sonar.echo.object_echo import Occluders, add_object
from ods.sim_sonar.echo.rays.detail import detail_of
from ods.sim_sonar.echo.rays.ray_budget import MAX_CELLS, ray_fan_of, rivals_of, shares_of_error, within_range
from ods.sim_sonar.pose import VehiclePose
from ods.sim_sonar.sea_bed.model import SeaBedModel
from ods.sim_sonar.sea_bed.view import view_of
from ods.sim_sonar.sonar.grid import Grid


class Surroundings(NamedTuple):
    """What reflects."""

    objects: Bodies
    """In NED, where they are received (see `motion_during_reception`)."""
    sea_bed: SeaBedModel | None = None
    """None: open water."""
    shadows: bool = True
    """False: objects hide nothing; what the sea-bed hides is never seen."""
    turn_rad_per_m: float = 0.0
    """What the sonar's heading turns while an echo of the sea-bed comes from a metre farther."""


def mean_area(grid: Grid, surroundings: Surroundings, pose: VehiclePose, max_error: float = 0.03) -> Floats:
    """Return the mean image, (beams, samples) float64: the area, m2, that each sample receives, weighted by eq. 5.

    It is the sum of gamma(alpha) S^2(beta) B(bearing) cos(alpha) dA over the lit surfaces in its range bin, B
    being the beam's horizontal pattern. Spreading and absorption are taken as undone by the sonar's gain. `max_error`
    is the relative rms error that the image may have after a mean over 3 beams x 9 samples; detail.LEVEL_ERRORS has a
    ladder of values.
    """
    objects, sea_bed, shadows, turning = surroundings
    detail = detail_of(max_error)
    rotation = geometry.rotation_matrix(pose.attitude)
    image = np.zeros((len(grid.vertical) * len(grid.bearing_rad), grid.samples))
    view = view_of(sea_bed, grid, pose.position_ned, rotation, detail, turning)
    seen = to_sonar_frame(objects, pose.position_ned, rotation)
    shades, shaded = np.empty(len(objects) * MAX_CELLS, SHADE), 0
    rivals, errors = rivals_of(seen) & shadows, shares_of_error(seen, grid, max_error)
    for which in within_range(seen, grid):
        rays = ray_fan_of(seen, which, grid, errors[which])
        if len(rays.bearing) == 0:
            continue
        occluders = Occluders(rivals[which].nonzero()[0], view.hides_beyond(rays, grid))
        ranges = add_object(image, seen, which, occluders, rays, grid)
        if shadows:
            shaded = add_shades(shades, shaded, ranges, rays, which)
    view.add_to(image, grid, shades[:shaded])
    return np.maximum(image, 0.0, out=image)
