"""Share of the water ahead that is not known to be empty."""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.messages import Clearance

OWN_M = 6.0
"""Nearer than this, water counts as empty before the nearest obstacle or echo: a fan has no width there."""


def unknown_m(places: Floats, clearance: Clearance | None, look_m: float) -> Floats:
    """Return (n,) how much of the next `look_m` of each path, (n, m, 2), is not known to be empty, m."""
    n = len(places)
    if clearance is None or clearance.pose is None or not clearance.valid:
        return np.full(n, look_m)
    nearest = np.array([math.inf if each is None else each for each in clearance.nearest_m])
    sectors = np.array(clearance.clear_from_m), np.array(clearance.clear_to_m), nearest
    unknown = np.empty(n)
    native.unknown_water(places, *clearance.pose.position_ned[:2], sectors, OWN_M, look_m, unknown)
    return unknown
