"""The mean image of a scene seen by a sonar: arrays in, one array out; no noise, no levels."""

import numpy as np

from ods.base import geometry
from ods.base.arrays import Floats
from ods.sim_sonar.echo import bodies
from ods.sim_sonar.echo.detail import detail_of
from ods.sim_sonar.echo.object_echo import add_object
from ods.sim_sonar.echo.ray_budget import fan_of, rivals_of, shares_of_error
from ods.sim_sonar.echo.shadow import SHADE_COLUMNS, shades_of
from ods.sim_sonar.sea_bed.model import Bed
from ods.sim_sonar.sea_bed.view import view_of
from ods.sim_sonar.sonar.grid import Grid


def mean_area(
    grid: Grid,
    objects: Floats,
    sea_bed: Bed | None,
    position_ned: Floats,
    attitude: Floats,
    *,
    shadows: bool = True,
    max_error: float = 0.03,
) -> Floats:
    """Return the mean image, (beams, samples) float64: the area, m2, that each sample hears, weighted by eq. 5.

    A sample hears the sum of gamma(alpha) S^2(beta) B(bearing) cos(alpha) dA over the lit surfaces in its range bin, B
    being the beam's horizontal pattern. Spreading and absorption are taken as undone by the sonar's gain. `objects` are
    (n, bodies.COLUMNS) rows in NED, m; `sea_bed`: see bed.make_bed; `position_ned` (3,), m; `attitude` (4,), body to
    global. Without `shadows` objects hide nothing; what the sea-bed hides is never seen. `max_error` is the relative
    rms error that the image may have after a mean over 3 beams x 9 samples; detail.levels() has a ladder of values.
    """
    detail = detail_of(max_error)
    rotation = geometry.rotation_matrix(attitude)
    image = np.zeros((len(grid.vertical) * len(grid.bearing_rad), grid.samples))
    view = view_of(sea_bed, grid, position_ned, rotation, detail)
    seen = bodies.to_sonar_frame(objects, position_ned, rotation)
    shades = [np.empty((0, SHADE_COLUMNS))]
    rivals, errors = rivals_of(seen), shares_of_error(seen, grid, max_error)
    for which in range(len(seen)):
        fan = fan_of(seen[which], grid, errors[which])
        if len(fan.bearing) == 0:
            continue
        limit = view.hides_beyond(fan, grid)
        hiders = np.flatnonzero(rivals[which] & shadows)
        ranges = add_object(image, seen, which, hiders, fan.bearing, fan.elevation, limit, grid)
        if shadows:
            shades.append(shades_of(ranges, fan.bearing, fan.elevation, which))
    view.add_to(image, grid, np.concatenate(shades))
    return np.maximum(image, 0.0, out=image)
