"""Shadows: what an object hides of the sea-bed behind it.

At one bearing a convex object hides one interval of elevations. A shade is a row of SHADE_COLUMNS numbers, taken from
the fan of rays that has met the object: least and greatest bearing, sines of least and greatest elevation, range, and
the object's number.
"""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.echo.bodies import FAR
from ods.sim_sonar.kernel import compiled

WEST, EAST, LOW, HIGH, RANGE, OBJECT, SHADE_COLUMNS = 0, 1, 2, 3, 4, 5, 6


@compiled
def shades_of(ranges: Floats, bearing: Floats, elevation: Floats, which: int) -> Floats:
    """Return the shades (n, SHADE_COLUMNS) of an object: `ranges` (bearings, elevations) is FAR where it is not met."""
    out = np.empty((ranges.shape[0], SHADE_COLUMNS))
    count = 0
    for a in range(ranges.shape[0]):
        first, last, nearest = ranges.shape[1], -1, FAR
        for e in range(ranges.shape[1]):
            if ranges[a, e] < FAR:
                first, last, nearest = min(first, e), e, min(nearest, ranges[a, e])
        if last < 0:
            continue
        out[count, WEST], out[count, EAST] = bearing[a], bearing[a + 1]
        out[count, LOW], out[count, HIGH] = math.sin(elevation[first]), math.sin(elevation[last + 1])
        out[count, RANGE], out[count, OBJECT] = nearest, which
        count += 1
    return out[:count]


@compiled
def shades_on(shades: Floats, west: float, east: float) -> Floats:
    """Return one mean shade of each object on a column between two bearings; WEST becomes the share that it takes."""
    count = -1
    mine = np.empty(shades.shape)
    for k in range(len(shades)):
        part = (min(east, shades[k, EAST]) - max(west, shades[k, WEST])) / (east - west)
        if part <= 0.0:
            continue
        if count < 0 or mine[count, OBJECT] != shades[k, OBJECT]:
            count += 1
            mine[count] = 0.0
            mine[count, OBJECT] = shades[k, OBJECT]
        mine[count, WEST] += part
        for c in (LOW, HIGH, RANGE):
            mine[count, c] += part * shades[k, c]
    for k in range(count + 1):
        for c in (LOW, HIGH, RANGE):
            mine[k, c] /= mine[k, WEST]
    return mine[: count + 1]


@compiled
def visible_share(shades: Floats, low: float, high: float, distance: float) -> float:
    """Return how much of the elevations with sines `low` to `high`, `distance` m away, a column of the fan sees.

    `shades` are those of shades_on. What two objects hide is taken as the product of what each hides, which is exact
    but where the edges of both cross.
    """
    seen = 1.0
    for k in range(len(shades)):
        if shades[k, RANGE] < distance:
            part = min(high, shades[k, HIGH]) - max(low, shades[k, LOW])
            seen *= 1.0 - min(1.0, shades[k, WEST] * max(0.0, part) / (high - low))
    return seen
