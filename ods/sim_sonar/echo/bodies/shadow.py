"""Shadows: what an object hides of the sea-bed behind it.

At one bearing a convex object hides one interval of elevations.
"""

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats
from ods.compiled import native
from ods.sim_sonar.echo.rays.ray_budget import RayFan

SHADE = np.dtype(
    [
        ("west", np.float64),
        ("east", np.float64),
        ("low", np.float64),
        ("high", np.float64),
        ("range_m", np.float64),
        ("which", np.int64),
    ]
)
"""What the rays of one bearing that have met an object: least and greatest bearing, sines of least and greatest
elevation, range, the object's number."""
Shades = NDArray[np.void]
"""(n,) of SHADE."""


def add_shades(shades: Shades, count: int, ranges: Floats, rays: RayFan, which: int) -> int:
    """Set `shades`, from `count` on, to those of one more object; return how many there are then.

    Its rays met the object at `ranges` (bearings, elevations), FAR where they did not; there is one shade a bearing at
    most.
    """
    return int(native.add_shades(shades, count, ranges, rays, which))
