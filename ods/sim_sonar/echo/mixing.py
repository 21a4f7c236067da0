"""How thin columns of the fan become beams: each beam hears them through its horizontal pattern."""

from ods.base.arrays import Floats
from ods.compiled import native
from ods.sim_sonar.sonar.grid import Grid


def mix_evenly(
    image: Floats, columns: Floats, bins: tuple[int, int], bearing: Floats, grid: Grid, reach: float
) -> None:
    """Add the echo of evenly wide columns to bins from the first to before the last of `image` (beams, samples).

    `columns` (planes, columns, samples), per radian of bearing, lie between the borders `bearing`, rad; between them
    the sea-bed changes linearly, not in steps. A beam hears what lies beyond `reach` beam widths of its axis as the
    mean of all columns.
    """
    native.mix_evenly(image, columns, bins, bearing, grid, reach)
