"""Share of the water ahead that is not known to be empty."""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.messages import Clearance

OWN_M = 6.0
"""Nearer than this, water counts as empty before the nearest obstacle or echo: a fan has no width there."""


def unknown_m(places: Floats, clearance: Clearance | None, look_m: float) -> Floats:
    """Return (n,) how much of the next `look_m` of each path, (n, m, 2), is not known to be empty, m."""
    n = len(places)
    if clearance is None or clearance.pose is None or not clearance.valid:
        return np.full(n, look_m)
    offset = places - np.array(clearance.pose.position_ned[:2])
    away = np.hypot(offset[..., 0], offset[..., 1])
    count = len(clearance.clear_to_m)
    sector = (np.arctan2(offset[..., 1], offset[..., 0]) * (count / (2.0 * math.pi))).astype(np.intp)
    sector = np.where(offset[..., 1] < 0.0, sector - 1, sector) % count
    empty = away <= np.array(clearance.clear_to_m)[sector]
    empty &= away >= np.maximum(np.array(clearance.clear_from_m)[sector], 0.0)
    nearest = np.array([math.inf if each is None else each for each in clearance.nearest_m])[sector]
    steps = np.diff(away, axis=1, prepend=0.0)
    counts = ~empty & ((away > OWN_M) | (away > nearest)) & (away <= look_m)
    return np.asarray(np.where(counts, np.maximum(steps, 0.0), 0.0).sum(axis=1))
