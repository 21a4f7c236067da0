"""Number of rays for each object, and pairs of objects of which one may hide the other."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled import native
from ods.sim_sonar.echo.bodies.bodies import Bodies
from ods.sim_sonar.sonar.grid import Grid

MAX_CELLS = 720
"""Of one object in bearing, or in elevation."""


class RayFan(NamedTuple):
    """The rays for one object: borders of their cells, empty when nothing of it can be seen."""

    bearing: Floats
    """(columns + 1,) rad."""
    elevation: Floats
    """(columns, cells + 1) rad: evenly from the object's lower to its upper end at the column's middle."""
    farthest_m: float
    """Range, m, beyond which nothing of the object lies."""


def shares_of_error(seen: Bodies, grid: Grid, max_error: float) -> Floats:
    """Return the (n,) relative errors that the echoes of (n,) bodies in the sonar's frame may have.

    Together they make `max_error`.
    """
    errors = np.empty(len(seen))
    native.shares_of_error(seen, grid, max_error, errors)
    return errors


def ray_fan_of(bodies: Bodies, which: int, grid: Grid, max_error: float) -> RayFan:
    """Return the rays that hold what the sonar can see of a body, fine enough for a relative error of `max_error`."""
    bearing, elevation, size = np.empty(MAX_CELLS + 1), np.empty(MAX_CELLS * (MAX_CELLS + 1)), np.zeros(2, np.int64)
    farthest = native.ray_fan_of(bodies, which, grid, max_error, bearing, elevation, size)
    columns, cells = size.tolist()
    if columns == 0:
        return RayFan(np.empty(0), np.empty((0, 0)), 0.0)
    return RayFan(bearing[: columns + 1], elevation[: columns * (cells + 1)].reshape(columns, cells + 1), farthest)


def within_range(seen: Bodies, grid: Grid) -> list[int]:
    """Return the numbers of those of (n,) bodies in the sonar's frame that may be within its range."""
    away, sizes = (np.sqrt(np.square(seen[name]).sum(axis=1)) for name in ("centre", "half"))
    return np.flatnonzero(away - sizes <= grid.edge_m + grid.samples * grid.dr_m).tolist()


def rivals_of(seen: Bodies) -> Mask:
    """Return (n, n): whether, of (n,) bodies in the sonar's frame, the second may stand before the first."""
    rivals = np.empty((len(seen), len(seen)), np.bool_)
    native.rivals_of(seen, rivals)
    return rivals
