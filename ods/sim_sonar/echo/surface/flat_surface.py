"""A plane as the sonar sees it; its echo is that of kernels (flat_surface.h)."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.sim_sonar.sonar.grid import Grid


class FlatSurface(NamedTuple):
    """A plane as the sonar sees it."""

    down: Floats
    """(3,) unit vector from the sonar straight to the plane, in the sonar's frame: down, for a level sea-surface."""
    height_m: float
    """Distance of the plane."""
    weight: Floats
    """(samples,) gamma R^2, m2: eq. 3 at each sample's incidence angle, whose cosine is h / R."""
    nearness: Floats
    """(samples + 1,) 1 / R at the borders of the samples, 1/m."""


def flat_surface(grid: Grid, down: Floats, height_m: float, reflects: tuple[float, float, float]) -> FlatSurface:
    """Return a plane `height_m` away in the direction `down` (3,), sonar's frame; `reflects`: cd, cs, sigma in rad."""
    weight, nearness = np.empty(grid.samples), np.empty(grid.samples + 1)
    native.flat_surface(grid.edge_m, grid.dr_m, height_m, reflects, weight, nearness)
    return FlatSurface(down, height_m, weight, nearness)
