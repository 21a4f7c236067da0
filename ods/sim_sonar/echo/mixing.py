"""How thin columns of the fan become beams: each beam hears them through its horizontal pattern."""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.sonar.grid import Grid, beam_share

BLEND = 4
"""Places at which the change from one column to the next is sampled."""


@compiled
def pattern_width(grid: Grid) -> float:
    """Return the integral of the horizontal pattern over half a turn, rad."""
    widest = 0.5 * math.pi / grid.beam_width_rad
    return beam_share(grid.horizontal, -widest, widest) * grid.beam_width_rad


@compiled
def shares_of(bearing: Floats, grid: Grid, reach: float) -> Floats:
    """Return how much each beam hears of each column between the borders `bearing`, rad: (beams, columns).

    A beam hears nothing of columns beyond `reach` beam widths of its axis.
    """
    out = np.zeros((len(grid.bearing_rad), len(bearing) - 1))
    for beam in range(out.shape[0]):
        for a in range(out.shape[1]):
            begin = (bearing[a] - grid.bearing_rad[beam]) / grid.beam_width_rad
            finish = (bearing[a + 1] - grid.bearing_rad[beam]) / grid.beam_width_rad
            if finish >= -reach and begin <= reach:
                out[beam, a] = beam_share(grid.horizontal, begin, finish) * grid.beam_width_rad
    return out


@compiled
def blended_shares(bearing: Floats, grid: Grid, reach: float) -> Floats:
    """Return the same for evenly wide columns between which the sea-bed changes linearly, not in steps."""
    out = np.zeros((len(grid.bearing_rad), len(bearing) - 1))
    width = (bearing[1] - bearing[0]) / grid.beam_width_rad
    for beam in range(out.shape[0]):
        for a in range(out.shape[1]):
            begin = (bearing[a] - grid.bearing_rad[beam]) / grid.beam_width_rad
            if begin + width < -reach or begin > reach:
                continue
            for part in range(BLEND):
                shift = ((part + 0.5) / BLEND - 0.5) * width
                share = beam_share(grid.horizontal, begin + shift, begin + shift + width)
                out[beam, a] += share * grid.beam_width_rad / BLEND
    return out


@compiled
def mix(image: Floats, columns: Floats, first: int, last: int, shares: Floats) -> None:
    """Add `columns` (planes, columns, samples), per radian of bearing, to bins [first, last) of `image`.

    `shares` (beams, columns), rad.
    """
    beams = len(shares)
    for beam in range(beams):
        for a in range(shares.shape[1]):
            share = shares[beam, a]
            if share == 0.0:
                continue
            for plane in range(len(columns)):
                target = image[plane * beams + beam, first:last]
                source = columns[plane, a, first:last]
                for j in range(last - first):
                    target[j] += share * source[j]


@compiled
def mix_column(image: Floats, rows: Floats, bins: tuple[int, int], shares: Floats, heard_by: tuple[int, int]) -> None:
    """Add one column's `rows` (planes, samples), per radian of bearing, to the beams `heard_by`, first to last+1.

    `bins`: first and last+1; `shares` (beams,), rad.
    """
    first, last = bins
    if first >= last:
        return
    for plane in range(len(rows)):
        source = rows[plane, first:last]
        for beam in range(heard_by[0], heard_by[1]):
            share, target = shares[beam], image[plane * len(shares) + beam, first:last]
            for j in range(last - first):
                target[j] += share * source[j]


@compiled
def add_mean(image: Floats, columns: Floats, first: int, last: int, grid: Grid, share: Floats) -> None:
    """Add the mean of all `columns`, times each beam's `share`, rad, to bins [first, last) of `image`."""
    beams = len(grid.bearing_rad)
    count = columns.shape[1]
    for plane in range(len(columns)):
        mean = np.zeros(last - first)
        for a in range(count):
            source = columns[plane, a, first:last]
            for j in range(last - first):
                mean[j] += source[j]
        for beam in range(beams):
            target = image[plane * beams + beam, first:last]
            part = share[beam] / count
            for j in range(last - first):
                target[j] += part * mean[j]
