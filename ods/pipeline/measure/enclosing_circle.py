"""Smallest enclosing circles."""

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel

Points = Floats
"""(n, 2) Cartesian coordinates, m."""

_SLACK = 1e-9
"""Relative; a point this little outside a circle counts as on it."""


@kernel
def smallest_circle(points: Points) -> tuple[float, float, float]:
    """Return centre x, centre y and radius of the smallest circle that holds all points (n >= 1, 2).

    The circle is grown: the point farthest outside joins the at most three points that carry the circle, and the
    smallest circle of those four takes over, until none is outside (D. J. Elzinga, D. W. Hearn, Transportation Science
    6(4), 1972). The radius grows at every step, so it ends; a handful of steps is usual.
    """
    support = np.empty((4, 2))
    x, y, radius = points[0, 0], points[0, 1], 0.0
    support[0, 0], support[0, 1] = x, y
    count = 1
    for _ in range(10 * points.shape[0] + 10):
        farthest, reach = -1, (radius * (1.0 + _SLACK) + 1e-12) ** 2
        for i in range(points.shape[0]):
            dx, dy = points[i, 0] - x, points[i, 1] - y
            if dx * dx + dy * dy > reach:
                farthest, reach = i, dx * dx + dy * dy
        if farthest < 0:
            break
        support[count, 0], support[count, 1] = points[farthest, 0], points[farthest, 1]
        count, x, y, radius = _circle_of_support(support, count + 1)
    return x, y, radius


@kernel
def _circle_of_support(points: Points, count: int) -> tuple[int, float, float, float]:
    """Return the smallest circle of 2 to 4 points; the points that carry it are moved to the front and counted."""
    best = np.inf
    x, y = points[0, 0], points[0, 1]
    first, second, third = 0, 0, 0
    for i in range(count):
        for j in range(i + 1, count):
            for k in range(j, count):  # k == j stands for the pair alone
                cx, cy, r = _circle_through(points[i], points[j], points[k])
                if r < best and _holds(points, count, cx, cy, r):
                    best, x, y = r, cx, cy
                    first, second, third = i, j, k
    for place, chosen in enumerate((first, second, third)):  # in rising order, so none is overwritten too early
        points[place, 0], points[place, 1] = points[chosen, 0], points[chosen, 1]
    return 2 if third == second else 3, x, y, best


@kernel
def _circle_through(a: Points, b: Points, c: Points) -> tuple[float, float, float]:
    """Return the circle through three points, or the one with diameter ab when b == c; radius inf when in line."""
    if b[0] == c[0] and b[1] == c[1]:
        return 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * np.hypot(a[0] - b[0], a[1] - b[1])
    bx, by, cx, cy = b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]
    cross = 2.0 * (bx * cy - by * cx)
    if abs(cross) < 1e-12 * (bx * bx + by * by + cx * cx + cy * cy):
        return 0.0, 0.0, np.inf
    b2, c2 = bx * bx + by * by, cx * cx + cy * cy
    ux, uy = (cy * b2 - by * c2) / cross, (bx * c2 - cx * b2) / cross
    return a[0] + ux, a[1] + uy, np.hypot(ux, uy)


@kernel
def _holds(points: Points, count: int, x: float, y: float, radius: float) -> bool:
    limit = radius * (1.0 + _SLACK) + 1e-12
    outside = 0
    for i in range(count):
        outside += np.hypot(points[i, 0] - x, points[i, 1] - y) > limit
    return outside == 0
