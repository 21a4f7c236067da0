"""Shadows: what an object hides of the sea-bed behind it.

At one bearing a convex object hides one interval of elevations.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats
from ods.sim_sonar.echo.bodies import FAR
from ods.sim_sonar.echo.ray_budget import RayFan
from ods.sim_sonar.kernel import compiled

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
"""What the rays of one bearing that have met an object tell: least and greatest bearing, sines of least and greatest
elevation, range, the object's number."""
Shades = NDArray[np.void]
"""(n,) of SHADE."""

MEAN_SHADE = np.dtype(
    [
        ("share", np.float64),
        ("low", np.float64),
        ("high", np.float64),
        ("range_m", np.float64),
        ("which", np.int64),
    ]
)
"""What one object hides of a column: the share of its width; the rest is the mean over that."""
MeanShades = NDArray[np.void]
"""(n,) of MEAN_SHADE."""


@compiled
def add_shades(shades: Shades, count: int, ranges: Floats, rays: RayFan, which: int) -> int:
    """Set `shades`, from `count` on, to those of one more object; return how many there are then.

    Its rays met the object at `ranges` (bearings, elevations), FAR where they did not; there is one shade a bearing at
    most.
    """
    for a in range(ranges.shape[0]):
        first, last, nearest = ranges.shape[1], -1, FAR
        for e in range(ranges.shape[1]):
            if ranges[a, e] < FAR:
                first, last, nearest = min(first, e), e, min(nearest, ranges[a, e])
        if last < 0:
            continue
        shade = shades[count]
        shade["west"], shade["east"] = rays.bearing[a], rays.bearing[a + 1]
        shade["low"], shade["high"] = math.sin(rays.elevation[a, first]), math.sin(rays.elevation[a, last + 1])
        shade["range_m"], shade["which"] = nearest, which
        count += 1
    return count


@compiled
def shades_on(shades: Shades, west: float, east: float) -> MeanShades:
    """Return one mean shade of each object on a column between two bearings."""
    count = -1
    out = np.empty(len(shades), MEAN_SHADE)
    for k in range(len(shades)):
        shade = shades[k]
        part = (min(east, shade["east"]) - max(west, shade["west"])) / (east - west)
        if part <= 0.0:
            continue
        if count < 0 or out[count]["which"] != shade["which"]:
            count += 1
            new = out[count]
            new["share"], new["low"], new["high"], new["range_m"] = 0.0, 0.0, 0.0, 0.0
            new["which"] = shade["which"]
        mean = out[count]
        mean["share"] += part
        mean["low"] += part * shade["low"]
        mean["high"] += part * shade["high"]
        mean["range_m"] += part * shade["range_m"]
    for k in range(count + 1):
        mean = out[k]
        mean["low"] /= mean["share"]
        mean["high"] /= mean["share"]
        mean["range_m"] /= mean["share"]
    return out[: count + 1]


@compiled
def visible_share(shades: MeanShades, low: float, high: float, distance: float) -> float:
    """Return how much of the elevations with sines `low` to `high`, `distance` m away, a column of the fan sees.

    What two objects hide is taken as the product of what each hides, which is exact but where the edges of both cross.
    """
    seen = 1.0
    for k in range(len(shades)):
        shade = shades[k]
        if shade["range_m"] < distance:
            part = min(high, shade["high"]) - max(low, shade["low"])
            seen *= 1.0 - min(1.0, shade["share"] * max(0.0, part) / (high - low))
    return seen
