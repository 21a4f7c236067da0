"""Smallest enclosing circles."""

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native

Points = Floats
"""(n, 2) Cartesian coordinates, m."""


def smallest_circle(points: Points) -> tuple[float, float, float]:
    """Return centre x, centre y and radius of the smallest circle that holds all points (n >= 1, 2)."""
    circle = np.empty(3)
    native.smallest_circle(points, circle)
    x, y, radius = circle.tolist()
    return x, y, radius
