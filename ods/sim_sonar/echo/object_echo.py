"""The mean echo of one object, by columns of bearing that just cover it.

At each bearing a plane is drawn in closed form (see flat_surface.h), a sphere or cylinder by rays through the centres
of cells of elevation that go from its lower to its upper end. A cell returns gamma S^2 R^2 over its solid angle (eq. 5;
R^2 turns solid angle into area) and spreads it, as a trapezoid, over the ranges that the slope towards its neighbours
spans, which is exact for a flat patch: few rays give a smooth profile. Columns are then mixed into the beams by the
horizontal pattern, side lobes included, as far as half a turn ahead goes.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.compiled import native
from ods.sim_sonar.echo.bodies.bodies import Bodies
from ods.sim_sonar.echo.rays.ray_budget import RayFan
from ods.sim_sonar.sonar.grid import Grid


class Occluders(NamedTuple):
    """Surfaces that may hide an object."""

    rivals: Ints
    """Numbers of the bodies that may."""
    limit: Floats
    """(bearings, elevations) ranges at which the sea-bed does."""


def add_object(image: Floats, bodies: Bodies, which: int, occluders: Occluders, rays: RayFan, grid: Grid) -> Floats:
    """Add the mean echo, m2, of body `which` to `image` (beams, samples) and return the ranges its rays meet it at.

    The ranges (bearings, elevations) are FAR where the object is not met first.
    """
    ranges = np.empty_like(occluders.limit)
    native.add_object(image, bodies, which, occluders, rays, grid, ranges)
    return ranges
