"""Is an object expected in this image, at the edge of the sector, or not at all?"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.base.kernel import kernel
from ods.messages import Sector
from ods.tracker.measurement.model import Sight

ROOT2 = 2.0**0.5
ROOT3 = 3.0**0.5
LEAST_SIGMA = 1e-6
"""Keeps the distance to the edge, in standard deviations, finite."""


class View(NamedTuple):
    """(n,) arrays."""

    inside: Mask
    """The predicted place is inside the sector."""
    probability: Floats
    """That the object is inside the sector, at a range that was processed."""
    skipped: Mask
    """The predicted place is inside the sector, at a range that was more likely left out than processed."""
    watched: Floats
    """Probability that the sonar looks at the object: 0 unless it is so far inside that a missing echo says something,
    then the share of its vertical interval that the fan covers, times the probability that its range was
    processed."""


def view(
    sight: Sight, sector: Sector, looked: Sequence[tuple[float, float]], edge_sigmas: float, fan_turn: float = 0.0
) -> View:
    """Compare predictions with the sector; an object is watched that is at least `edge_sigmas` inside its edges.

    looked: ranges (from, to) that were processed; empty: all. fan_turn: see `Scan`. Vertically an object is anywhere in
    an interval as wide as its variance allows.
    """
    ranges = np.array(looked, np.float64).reshape(-1, 2)
    flags, shares = _view(sight, *_edges(sector), sector.half_vertical_rad, fan_turn, edge_sigmas, ranges)
    return View(flags[0], shares[0], flags[1], shares[1])


@kernel
def _view(
    sight: Sight,
    nearest: float,
    farthest: float,
    port: float,
    starboard: float,
    half_vertical: float,
    fan_turn: float,
    margin: float,
    looked: Floats,
) -> tuple[Mask, Floats]:
    """Return the fields of `View`: (2, n) inside and skipped, (2, n) probability and watched."""
    n = len(sight.range_m)
    flags, shares = np.empty((2, n), np.bool_), np.empty((2, n))
    for i in range(n):
        sigma_range = math.sqrt(sight.along[i]) + LEAST_SIGMA
        sigma_bearing = math.sqrt(sight.across[i]) / sight.horizontal[i] + LEAST_SIGMA
        in_fan = sight.bearing[i] - fan_turn * sight.range_m[i]
        to_edge = min(
            min(sight.range_m[i] - nearest, farthest - sight.range_m[i]) / sigma_range,
            min(in_fan - port, starboard - in_fan) / sigma_bearing,
        )
        covered = _covered(sight.range_m[i], sight.elevation[i], sight.vertical[i], half_vertical)
        processed = _processed(sight.range_m[i], sigma_range, looked)
        flags[0, i] = to_edge >= 0.0 and covered > 0.0
        flags[1, i] = flags[0, i] and processed < 0.5
        shares[0, i] = _normal(to_edge) * processed
        shares[1, i] = covered * processed if to_edge >= margin else 0.0
    return flags, shares


@kernel
def _processed(distance: float, sigma: float, looked: Floats) -> float:
    """Return the probability that the range of an object is one of `looked`, (k, 2); 1 when there are none."""
    if len(looked) == 0:
        return 1.0
    total = 0.0
    for begin, stop in looked:
        total += _normal((stop - distance) / sigma) - _normal((begin - distance) / sigma)
    return total


@kernel
def _normal(deviate: float) -> float:
    """Return the standard normal distribution function."""
    return 0.5 * math.erfc(-deviate / ROOT2)


@kernel
def _covered(distance: float, elevation: float, variance: float, half_vertical: float) -> float:
    """Return the share of an object's vertical interval that the fan covers."""
    half_fan = distance * math.sin(half_vertical)
    half_object = ROOT3 * math.sqrt(variance) + LEAST_SIGMA
    middle = distance * math.sin(elevation)
    shared = min(half_fan, middle + half_object) - max(-half_fan, middle - half_object)
    return max(shared, 0.0) / (2.0 * half_object)


def near_sector(sight: Sight, sector: Sector, margin_m: float) -> Mask:
    """Tell (n,) which predicted places are inside the sector or nearer to it than about `margin_m`."""
    return _near(sight, *_edges(sector), margin_m)


@kernel
def _near(sight: Sight, nearest: float, farthest: float, port: float, starboard: float, margin_m: float) -> Mask:
    near = np.empty(len(sight.range_m), np.bool_)
    for i in range(len(near)):
        turn = margin_m / sight.horizontal[i]
        near[i] = (nearest - margin_m <= sight.range_m[i] <= farthest + margin_m) and (
            port - turn <= sight.bearing[i] <= starboard + turn
        )
    return near


def _edges(sector: Sector) -> tuple[float, float, float, float]:
    return sector.range_min_m, sector.range_max_m, sector.bearing_min_rad, sector.bearing_max_rad


@kernel
def hidden(sight: Sight, radius: Floats, hiding: Mask) -> Mask:
    """Tell (n,) whose predicted place is behind a nearer object, one of `hiding`, as seen from the sonar.

    `radius`: (n,) m. The shadow is as wide as the object in front, and the standard deviation of the bearing wider.
    """
    n = len(sight.range_m)
    behind = np.zeros(n, np.bool_)
    for front in range(n):
        if not hiding[front]:
            continue
        half_width = math.asin(min(radius[front] / sight.range_m[front], 1.0))
        beyond = sight.range_m[front] + radius[front]
        for i in range(n):
            if sight.range_m[i] > beyond:
                sigma = math.sqrt(sight.across[i]) / sight.horizontal[i]
                behind[i] |= abs(sight.bearing[i] - sight.bearing[front]) <= half_width + sigma
    return behind
