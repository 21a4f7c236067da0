"""How many rays each object needs, and which objects may hide which."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.sim_sonar.echo.bodies import FAR, PLANE, SPHERE, Bodies, Body, bounding_radius, hit
from ods.sim_sonar.echo.silhouette import RIGHT, bearing_marks, elevation_span
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import LIT_BEYOND_WIDTHS, Grid, mean_two_way

MAX_CELLS = 720
"""Of one object in bearing, or in elevation."""
FEWEST, LOBE = 3.0, 0.5
"""Columns of an object, and in its facets' lobe, at least, over the root of the allowed error."""
SHIFT = 50.0
"""Samples by which the range may change from column to column, over that root."""
MAX_PARTS = 16
PLANE_LOBES = 1.6
"""Cells of elevation of a plane, per radian, over those of a whole sphere: they tell what hides it."""
ASIDE = 2.0
"""Columns of endless planes that only side lobes hear are wider by this."""
TINY = 1e-9
"""Share of a width that is next to none."""
LOOSEST = 4.0
"""Error that a faint object's own echo may have, over that of the image."""


class RayFan(NamedTuple):
    """The rays for one object: borders of their cells, empty when nothing of it can be seen."""

    bearing: Floats
    """(columns + 1,) rad."""
    elevation: Floats
    """(columns, cells + 1) rad: evenly from the object's lower to its upper end at the column's middle."""
    farthest_m: float
    """Range, m, beyond which nothing of the object lies."""


@compiled
def shares_of_error(seen: Bodies, grid: Grid, max_error: float) -> Floats:
    """Return the (n,) relative errors that the echoes of (n,) bodies in the sonar's frame may have.

    Together they make `max_error`. An echo that fills n samples with the power a counts for a / sqrt(n) in the image's
    rms, its rays cost as one over its error: least work is where the error goes as that to the power -2/3. Planes keep
    `max_error`.
    """
    out = np.full(len(seen), max_error)
    weight = np.zeros(len(seen))
    for k in range(len(seen)):
        if seen[k]["kind"] != PLANE:
            weight[k] = _weight(seen[k], grid)
    total, parts = np.sum(weight**2), np.sum(weight ** (2.0 / 3.0))
    for k in range(len(seen)):
        if weight[k] > 0.0:
            share = math.sqrt(total / parts) / weight[k] ** (2.0 / 3.0)
            out[k] = max_error * min(share, LOOSEST)
    return out


@compiled
def _weight(body: Body, grid: Grid) -> float:
    """Return about how much a sphere or cylinder counts in the rms of the image."""
    x, y, z = body["centre"][0], body["centre"][1], body["centre"][2]
    half = body["half"]
    radius = math.sqrt(half[0] * max(half[0], half[2]))
    distance = max(math.sqrt(x * x + y * y + z * z), radius)
    sine, reach = -z / distance, radius / distance
    heard = 0.0
    for plane in range(len(grid.vertical)):
        heard += mean_two_way(grid.vertical[plane], max(sine - reach, -1.0), min(sine + reach, 1.0))
    samples = max(1.0, radius / grid.dr_m) * max(1.0, 2.0 * reach / grid.beam_width_rad)
    return float((body["cd"] + body["cs"]) * heard * radius * radius / math.sqrt(samples))


@compiled
def ray_fan_of(bodies: Bodies, which: int, grid: Grid, max_error: float) -> RayFan:
    """Return the rays that hold what the sonar can see of a body, fine enough for a relative error of `max_error`."""
    body = bodies[which]
    nothing = RayFan(np.empty(0), np.empty((0, 0)), 0.0)
    nearest, farthest = _reach(body)
    if nearest > grid.edge_m + grid.samples * grid.dr_m:
        return nothing
    end_m = grid.edge_m + grid.samples * grid.dr_m
    marks = np.minimum(np.maximum(bearing_marks(body), -RIGHT), RIGHT)
    low, high = marks[0], marks[-1]
    if low >= high:
        return nothing
    finest = 3.3 / math.sqrt(max_error)
    if body["kind"] == SPHERE:
        across = max(finest, 0.33 * finest / body["sigma_rad"], (high - low) / _widest(grid, max_error))
        bearing = _borders(low, high, across)
    else:
        bearing = _uneven(body, marks, grid, max_error)
    spans = np.empty((len(bearing) - 1, 2))
    for a in range(len(spans)):
        spans[a] = elevation_span(body, 0.5 * (bearing[a] + bearing[a + 1]), end_m)
    lobes = 0.33 * finest / body["sigma_rad"]
    if body["kind"] == PLANE:
        lobes *= np.max(spans[:, 1] - spans[:, 0]) * PLANE_LOBES
    cells = min(MAX_CELLS, math.ceil(max(finest, lobes)))
    elevation = np.zeros((len(spans), cells + 1))
    for a in range(len(spans)):
        bottom, top = spans[a, 0], spans[a, 1]
        if bottom < top:
            elevation[a] = np.arange(0.0, cells + 1.0) * ((top - bottom) / cells) + bottom
    return RayFan(bearing, elevation, farthest)


@compiled
def _widest(grid: Grid, max_error: float) -> float:
    """Return the widest column that the beams' pattern allows, rad."""
    return float(grid.beam_width_rad * min(0.5, 3.0 * math.sqrt(max_error)))


@compiled
def _uneven(body: Body, marks: Floats, grid: Grid, max_error: float) -> Floats:
    """Return borders of columns of a cylinder or plane: at its corners, and closer where its range changes fast."""
    root, span = math.sqrt(max_error), marks[-1] - marks[0]
    widest = min(_widest(grid, max_error), span * root / FEWEST, body["sigma_rad"] * root / LOBE)
    margin, endless = LIT_BEYOND_WIDTHS * grid.beam_width_rad, bounding_radius(body) > grid.samples * grid.dr_m
    west, east = grid.bearing_rad[0] - margin, grid.bearing_rad[-1] + margin
    marks = np.sort(np.append(marks, np.array([min(max(x, marks[0]), marks[-1]) for x in (west, east)])))
    widest = max(widest, span / (MAX_CELLS - len(marks)))
    out = np.empty(MAX_CELLS + 1)
    out[0], used = marks[0], 0
    for mark in range(len(marks) - 1):
        start, part = marks[mark], marks[mark + 1] - marks[mark]
        aside = endless and (start >= east or start + part <= west)
        # upper and lower corners of an upright plane are one mark but for rounding: no column between them
        count = math.ceil(part / (ASIDE * widest if aside else widest)) if part > TINY * span else 0
        before = _middle_range(body, start + TINY * part)
        for k in range(count):
            begin, end = start + part * k / count, start + part * (k + 1) / count
            after = _middle_range(body, end - TINY * part)
            parts = 1
            if before < FAR and after < FAR and not aside:
                parts += int(abs(after - before) / (SHIFT * grid.dr_m * root))
            left = MAX_CELLS - used - (count - k) - math.ceil((marks[-1] - start - part) / widest) - len(marks)
            parts = max(1, min(parts, MAX_PARTS, left))
            for step in range(parts):
                used += 1
                out[used] = begin + (end - begin) * (step + 1) / parts
            before = after
    return out[: used + 1]


@compiled
def _middle_range(body: Body, bearing_rad: float) -> float:
    """Return the range of the middle of what a bearing sees of a body, m; FAR when there is nothing."""
    low, high = elevation_span(body, bearing_rad, FAR)
    if low >= high:
        return FAR
    upward = 0.5 * (low + high)
    level = math.cos(upward)
    return float(hit(body, level * math.cos(bearing_rad), level * math.sin(bearing_rad), -math.sin(upward))[0])


@compiled
def rivals_of(seen: Bodies) -> Mask:
    """Return (n, n): whether, of (n,) bodies in the sonar's frame, the second may stand before the first."""
    count = len(seen)
    out = np.zeros((count, count), np.bool_)
    distance, radius, half = np.empty(count), np.empty(count), np.empty(count)
    place = np.empty((count, 3))
    for k in range(count):
        centre = seen[k]["centre"]
        x, y, z = centre[0], centre[1], centre[2]
        place[k, 0], place[k, 1], place[k, 2] = x, y, z
        distance[k] = math.sqrt(x * x + y * y + z * z)
        radius[k] = bounding_radius(seen[k])
        half[k] = math.asin(radius[k] / distance[k]) if distance[k] > radius[k] else math.pi
    for k in range(count):
        for other in range(count):
            if other == k or distance[other] - radius[other] >= distance[k] + radius[k]:
                continue
            apart = math.pi
            if distance[k] * distance[other] > 0.0:
                product = 0.0
                for c in range(3):
                    product += place[k, c] * place[other, c]
                apart = math.acos(min(max(product / (distance[k] * distance[other]), -1.0), 1.0))
            out[k, other] = apart < half[k] + half[other]
    return out


@compiled
def _reach(body: Body) -> tuple[float, float]:
    """Return ranges, m, between which all of a body lies."""
    x, y, z = body["centre"][0], body["centre"][1], body["centre"][2]
    distance, radius = math.sqrt(x * x + y * y + z * z), bounding_radius(body)
    return distance - radius, distance + radius


@compiled
def _borders(low: float, high: float, wanted: float) -> Floats:
    """Return the borders of about `wanted` even cells."""
    cells = min(MAX_CELLS, max(2, math.ceil(wanted)))
    return np.arange(0.0, cells + 1.0) * ((high - low) / cells) + low
