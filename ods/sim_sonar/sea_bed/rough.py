"""A rough sea-bed's echo: columns of steps over its facets, marched outwards from the sonar.

A column is a thin slice of the fan at one bearing. Going out, each step is a short piece of sea-bed of which the sonar
sees what rises above all before it (the horizon). The piece returns gamma S^2 R^2 over the elevations that it fills
(eq. 5; R^2 turns solid angle into area), spread over the ranges that it spans. gamma is that of the facet's own slope.
Far away, where a column grows wider than the sea-bed's structure, it is split in two, which both inherit its horizon.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Floats32
from ods.sim_sonar.echo.bodies import FAR
from ods.sim_sonar.echo.interpolation import interpolate
from ods.sim_sonar.echo.ray_budget import RayFan
from ods.sim_sonar.echo.shadow import Shades, shades_on, visible_share
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import Grid

STEEPEST = 0.02
"""Least cosine between a step and the ray that is told apart from 0: there the whole step lies at one range."""
LEAST_LEAN = 0.02
"""Least cosine between the sonar's axis and a facet's normal, times the normal's length, at which it is a slope."""
LEANING = 1.0002
"""One over the cosine of the lean, about one degree, above which a trace is surveyed twice."""

PIECE = np.dtype(
    [
        ("near", np.float64),
        ("far", np.float64),
        ("low", np.float64),
        ("high", np.float64),
        ("gamma_near", np.float64),
        ("gamma_far", np.float64),
        ("density_near", np.float64),
        ("density_far", np.float64),
        ("seen", np.float64),
    ]
)
"""A visible piece of sea-bed: of its two ends the ranges, sines of elevation, gamma and density; and the share of it
that no object hides."""
Pieces = NDArray[np.void]
"""(n,) of PIECE."""


class RoughBed(NamedTuple):
    """A rough sea-bed as the sonar sees it; its frame is the mean plane's: x, y in the plane, z down."""

    nodes: Floats32
    """HeightField.nodes, flattened."""
    rows: int
    columns: int
    """Facets of the field in x and in y."""
    facet_m: float
    corner_m: tuple[float, float]
    repeats: bool
    sonar_m: Floats
    """(3,) the sonar in the sea-bed's frame; z is negative."""
    turn: Floats
    """(3, 3) from the sonar's frame to the sea-bed's, at transmission."""
    turning: float
    """What the sonar turns about the sea-bed's normal while an echo comes from a metre farther, rad."""
    gamma: Floats
    """Eq. 3 over cos(alpha), even from 0 to 1."""


class Trace(NamedTuple):
    """The half plane of one bearing, in the sea-bed's frame; places in facets from the field's corner."""

    start: tuple[float, float]
    """Below the sonar."""
    ahead: tuple[float, float]
    """Change of place per metre ahead."""
    upward: tuple[float, float]
    """Change of place per metre up the sonar's axis."""
    toward: tuple[float, float]
    """Direction ahead, metres in x and y per metre."""
    across: tuple[float, float, float]
    """Unit normal."""
    height: float
    """Of the sonar above the mean plane, m."""
    down: float
    """Fall per metre ahead."""
    per_side: tuple[float, float]
    """One over the field's facets in x and in y."""
    stretch: float
    """Metres up the sonar's axis per metre of height."""


class Land(NamedTuple):
    """The sea-bed at the steps of a trace."""

    up: Floats
    """Metres up the sonar's axis."""
    slope_x: Floats
    slope_y: Floats


class LandEcho(NamedTuple):
    """Its echo there."""

    reach: Floats
    """Range, m."""
    sine: Floats
    """Of elevation."""
    gamma: Floats
    density: Floats
    """Lit area per metre of range."""


class Zone(NamedTuple):
    """A ring of the sea-bed in which all columns are equally wide."""

    bearing: Floats
    """(columns + 1,) borders of the columns."""
    ahead: Floats
    """(steps + 1,) ends of the steps, m."""


@compiled
def trace_of(bed: RoughBed, bearing_rad: float) -> Trace:
    """Return the half plane of a bearing."""
    c, s, m, unit = math.cos(bearing_rad), math.sin(bearing_rad), bed.turn, 1.0 / bed.facet_m
    x, y = m[0, 0] * c + m[0, 1] * s, m[1, 0] * c + m[1, 1] * s
    return Trace(
        ((bed.sonar_m[0] - bed.corner_m[0]) * unit, (bed.sonar_m[1] - bed.corner_m[1]) * unit),
        (x * unit, y * unit),
        (-m[0, 2] * unit, -m[1, 2] * unit),
        (x, y),
        (m[0, 1] * c - m[0, 0] * s, m[1, 1] * c - m[1, 0] * s, m[2, 1] * c - m[2, 0] * s),
        -bed.sonar_m[2],
        m[2, 0] * c + m[2, 1] * s,
        (1.0 / bed.rows, 1.0 / bed.columns),
        1.0 / m[2, 2],
    )


@compiled
def _unknown_land(steps: int) -> Land:
    return Land(np.empty(steps), np.empty(steps), np.empty(steps))


@compiled
def survey(bed: RoughBed, trace: Trace, ahead: Floats, land: Land) -> None:
    """Set `land` to the sea-bed at the distances `ahead`, m, along a trace.

    When the vehicle leans, where a point of the sea-bed lies depends on its height: a second look corrects the first.
    """
    up = land.up
    for k in range(len(ahead)):
        up[k] = (ahead[k] * trace.down - trace.height) * trace.stretch
    _look(bed, trace, ahead, land)
    if trace.stretch > LEANING:
        _look(bed, trace, ahead, land)


@compiled
def _look(bed: RoughBed, trace: Trace, ahead: Floats, land: Land) -> None:
    """Set `land` to the sea-bed under the places that its `up` gives; beyond the field's border it is even.

    A sonar that turns while it listens looks at each place along the bearing that it has at reception; the sea-bed is
    turned back by that about the sonar, slopes and all, so that the trace is straight.
    """
    up, slope_x, slope_y = land
    line = np.uint64(3 * (bed.columns + 1))
    south, east = float(bed.rows), float(bed.columns)
    for k in range(len(ahead)):
        aside = bed.turning * ahead[k]
        onward = 1.0 - 0.5 * aside * aside  # a cosine: at 60 deg/s and 100 m it is right to 2e-4 of the range
        x = ahead[k] * trace.ahead[0] + up[k] * trace.upward[0]
        y = ahead[k] * trace.ahead[1] + up[k] * trace.upward[1]
        p = trace.start[0] + onward * x - aside * y
        q = trace.start[1] + onward * y + aside * x
        if bed.repeats:
            p -= south * math.floor(p * trace.per_side[0])
            q -= east * math.floor(q * trace.per_side[1])
        beyond_x, beyond_y = not 0.0 <= p <= south, not 0.0 <= q <= east
        p, q = min(max(p, 0.0), south), min(max(q, 0.0), east)
        i, j = min(math.floor(p), south - 1.0), min(math.floor(q), east - 1.0)
        corner = np.uint64(np.int64(i)) * line + np.uint64(3) * np.uint64(np.int64(j))
        a, b = np.float32(p - i), np.float32(q - j)
        height = _between(bed.nodes, corner, line, a, b)
        rise_x = 0.0 if beyond_x else _between(bed.nodes, corner + np.uint64(1), line, a, b)
        rise_y = 0.0 if beyond_y else _between(bed.nodes, corner + np.uint64(2), line, a, b)
        slope_x[k], slope_y[k] = onward * rise_x + aside * rise_y, onward * rise_y - aside * rise_x
        up[k] = (ahead[k] * trace.down - trace.height + height) * trace.stretch


@compiled
def _between(nodes: Floats32, corner: np.uint64, line: np.uint64, a: np.float32, b: np.float32) -> np.float32:
    """Interpolate between the four nodes of a facet; unsigned places, or each load is checked for a negative one."""
    right = corner + np.uint64(3)
    first = nodes[corner] + a * (nodes[corner + line] - nodes[corner])
    second = nodes[right] + a * (nodes[right + line] - nodes[right])
    return np.float32(first + b * (second - first))


@compiled
def _reflect(bed: RoughBed, trace: Trace, ahead: Floats, land: Land, echo: LandEcho) -> None:
    """Set `echo` from `land`; the density is R^2 d(sine) / dR."""
    up, slope_x, slope_y = land
    reach, sine, gamma, density = echo
    upright = 1.0 / trace.stretch
    lean_x, lean_y = bed.turn[0, 2], bed.turn[1, 2]
    toward_x, toward_y = trace.toward
    across_x, across_y, across_z = trace.across
    for k in range(len(ahead)):
        x, y = slope_x[k], slope_y[k]
        distance = max(math.sqrt(ahead[k] * ahead[k] + up[k] * up[k]), 1e-9)
        slope = (trace.down + x * toward_x + y * toward_y) / max(upright + x * lean_x + y * lean_y, LEAST_LEAN)
        facing = max(ahead[k] * slope - up[k], 0.0)
        aside = x * across_x + y * across_y + across_z
        normal = 1.0 + x * x + y * y
        tilted = max(0.0, normal - aside * aside) / (normal * (1.0 + slope * slope))
        reach[k] = distance
        sine[k] = up[k] / distance
        gamma[k] = facing / distance * math.sqrt(tilted)
        density[k] = ahead[k] * facing / max(abs(ahead[k] + up[k] * slope), STEEPEST * distance)
    for k in range(len(ahead)):
        gamma[k] = interpolate(bed.gamma, gamma[k])


@compiled
def march(bed: RoughBed, grid: Grid, zone: Zone, horizon: Floats, shades: Shades, out: Floats) -> tuple[int, int]:
    """Add the echo of a zone's columns, m2 per radian of bearing, to `out` (planes, columns, samples).

    `horizon` (columns,) is the sine of the elevation up to which each column is filled, and is moved on. Returns the
    first and last+1 sample touched.
    """
    bearing, ahead = zone
    steps = len(ahead)
    pieces = np.empty(steps, PIECE)
    land, echo = _unknown_land(steps), LandEcho(np.empty(steps), np.empty(steps), np.empty(steps), np.empty(steps))
    nearest, farthest = FAR, 0.0
    for c in range(len(bearing) - 1):
        trace = trace_of(bed, 0.5 * (bearing[c] + bearing[c + 1]))
        survey(bed, trace, ahead, land)
        _reflect(bed, trace, ahead, land, echo)
        count, horizon[c] = _see(echo, horizon[c], pieces)
        mine = shades_on(shades, bearing[c], bearing[c + 1])
        for k in range(count if len(mine) else 0):
            piece = pieces[k]
            piece["seen"] = visible_share(mine, piece["low"], piece["high"], 0.5 * (piece["near"] + piece["far"]))
        for plane in range(len(out)):
            _fill(out[plane, c], pieces[:count], grid.vertical[plane], grid)
        for k in range(count):
            nearest = min(nearest, pieces[k]["near"], pieces[k]["far"])
            farthest = max(farthest, pieces[k]["near"], pieces[k]["far"])
    first = min(max(int((nearest - grid.edge_m) / grid.dr_m), 0), grid.samples)
    return first, min(max(int((farthest - grid.edge_m) / grid.dr_m) + 1, first), grid.samples)


@compiled
def _see(echo: LandEcho, horizon: float, pieces: Pieces) -> tuple[int, float]:
    """Set `pieces` to what is seen along a trace; return their number and the new horizon."""
    count = 0
    reach, sine, gamma, density = echo
    for k in range(1, len(reach)):
        low = max(sine[k - 1], horizon)
        if sine[k] <= low:
            continue
        horizon = sine[k]
        rest = (sine[k] - low) / (sine[k] - sine[k - 1])
        piece = pieces[count]
        piece["near"], piece["far"] = reach[k] - rest * (reach[k] - reach[k - 1]), reach[k]
        piece["low"], piece["high"] = low, sine[k]
        piece["gamma_near"], piece["gamma_far"] = gamma[k] - rest * (gamma[k] - gamma[k - 1]), gamma[k]
        piece["density_near"] = density[k] - rest * (density[k] - density[k - 1])
        piece["density_far"] = density[k]
        piece["seen"] = 1.0
        count += 1
    return count, horizon


@compiled
def _fill(row: Floats, pieces: Pieces, vertical: Floats, grid: Grid) -> None:
    """Add the echo of `pieces` as heard by one vertical plane to `row` (samples,)."""
    per_bin = 1.0 / grid.dr_m
    for k in range(len(pieces)):
        piece = pieces[k]
        near, far = piece["near"], piece["far"]
        low, high = piece["low"], piece["high"]
        first = piece["gamma_near"] * interpolate(vertical, 0.5 + 0.5 * low)
        second = piece["gamma_far"] * interpolate(vertical, 0.5 + 0.5 * high)
        one, other = piece["density_near"], piece["density_far"]
        middle = 0.5 * (near + far)
        # gamma and density change linearly: the mean of their product is more than the product of their means
        power = 0.5 * (first + second) * middle * middle * (high - low)
        power += (second - first) * (other - one) * (far - near) / 12.0
        if power > 0.0:
            begin, finish = (near - grid.edge_m) * per_bin, (far - grid.edge_m) * per_bin
            _ramp(row, piece["seen"] * power, begin, finish, first * one, second * other)


@compiled
def _ramp(row: Floats, power: float, one: float, other: float, at_one: float, at_other: float) -> None:
    """Spread `power` over the bins from `one` to `other`, in a density that changes linearly as the two given do."""
    if other < one:
        one, other, at_one, at_other = other, one, at_other, at_one
    begin, finish = one, max(other, one + 1e-6)
    total = at_one + at_other
    if total <= 0.0:
        at_one, at_other, total = 1.0, 1.0, 2.0
    per_bin = 1.0 / (finish - begin)
    unit = 2.0 * power * per_bin / total
    rise = (at_other - at_one) * unit * per_bin
    start = at_one * unit - rise * begin
    low, high = max(begin, 0.0), min(finish, float(len(row)))
    if low >= high:
        return
    first, last = int(low), min(int(high), len(row) - 1)
    if first == last:
        row[first] += (high - low) * (start + rise * 0.5 * (low + high))
        return
    row[first] += (first + 1 - low) * (start + rise * 0.5 * (low + first + 1))
    row[last] += (high - last) * (start + rise * 0.5 * (high + last))
    for j in range(first + 1, last):
        row[j] += start + rise * (j + 0.5)


@compiled
def meet_ranges(bed: RoughBed, rays: RayFan, ahead: Floats, coarse_rad: float) -> Floats:
    """Return the (bearings, elevations) ranges, FAR where there is none, at which rays meet the sea-bed.

    Rays beyond the last step meet nothing. Cells within `coarse_rad` of bearing share one trace.
    """
    bearing, elevation = rays.bearing, rays.elevation
    aim = np.sin(0.5 * (elevation[:, 1:] + elevation[:, :-1]))
    out = np.full(aim.shape, FAR)
    land = _unknown_land(len(ahead))
    a = 0
    while a < len(out):
        end = a + 1
        while end < len(out) and bearing[end + 1] - bearing[a] <= coarse_rad:
            end += 1
        survey(bed, trace_of(bed, 0.5 * (bearing[a] + bearing[end])), ahead, land)
        for column in range(a, end):
            _meet(land.up, aim[column], ahead, out[column])
        a = end
    return out


@compiled
def _meet(up: Floats, aim: Floats, ahead: Floats, out: Floats) -> None:
    """Set `out` to the ranges at which rays of rising sines of elevation, `aim`, meet the sea-bed."""
    e, past, before = 0, 0.0, -1.0
    for k in range(len(ahead)):
        reach = max(math.sqrt(ahead[k] * ahead[k] + up[k] * up[k]), 1e-9)
        sine = up[k] / reach
        while e < len(out) and aim[e] < sine:
            share = (aim[e] - before) / (sine - before) if aim[e] > before else 0.0
            out[e] = past + share * (reach - past)
            e += 1
        past, before = reach, sine
        if e == len(out):
            break
