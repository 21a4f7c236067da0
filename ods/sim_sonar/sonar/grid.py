"""What the image kernels know of the sonar: bins of range, beams, tables of the beam patterns."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.sonar.patterns import ELEVATION_NODES, NODES_PER_WIDTH

SUM_NODES = 4 * (ELEVATION_NODES - 1) + 1
"""Nodes of the vertical pattern's running integral, even in sin(elevation)."""
LIT_BEYOND_WIDTHS = 3.0
"""Beam widths of `Grid.lit_beyond_rad`."""


class Grid(NamedTuple):
    """A sonar in the shape that kernels take."""

    edge_m: float
    """Near edge of the first range bin."""
    dr_m: float
    samples: int
    bearing_rad: Floats
    """(beams of one plane,)."""
    beam_width_rad: float
    vertical: Floats
    """(planes, ELEVATION_NODES) S^2 over sin(elevation)."""
    vertical_sum: Floats
    """(planes, SUM_NODES) its running integral from sin(elevation) = -1 on."""
    horizontal: Floats
    """Running integral of the horizontal pattern over beam widths."""
    nodes_per_width: int
    """Nodes of `horizontal` in one beam width."""
    lit_beyond_rad: float
    """Angle of fine columns beyond the outer beams: only side lobes receive echoes from farther out."""


def grid_of(sonar: SonarModel) -> Grid:
    """Return the kernels' view of `sonar`."""
    return Grid(
        sonar.range0_m - 0.5 * sonar.dr_m,
        sonar.dr_m,
        sonar.samples,
        np.ascontiguousarray(sonar.plane_bearing_rad),
        sonar.beam_width_rad,
        sonar.vertical_two_way,
        _running_sum(sonar.vertical_two_way),
        sonar.horizontal_cumulative,
        NODES_PER_WIDTH,
        LIT_BEYOND_WIDTHS * sonar.beam_width_rad,
    )


def _running_sum(vertical: Floats) -> Floats:
    nodes = np.linspace(-1.0, 1.0, SUM_NODES)
    values = np.stack([np.interp(nodes, np.linspace(-1.0, 1.0, ELEVATION_NODES), row) for row in vertical])
    steps = 0.5 * (values[:, 1:] + values[:, :-1]) * (nodes[1] - nodes[0])
    return np.concatenate([np.zeros((len(vertical), 1)), np.cumsum(steps, axis=1)], axis=1)
