"""Speckle: what becomes of a mean intensity when the echoes of many scatterers add up by chance.

A field of independent normal numbers, one for the scatterers of each cell, is filtered to the correlation that pulse
and beams make, and turned into Gamma distributed intensity quantile by quantile, which gives any real number of looks.

The numbers are a function of seed, place in the image and the sonar's pose, which is divided into cells: one range
sample along a beam, one beam width across it and in heading, of which a whole number makes a turn. Each number has its
own borders between them, so that of all numbers a share 1 - d is still the same after a motion by d cells: the
scatterers that are still in the cell. No motion, same speckle; back at the same place, the same speckle again.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.base.frames import geometry
from ods.compiled import native
from ods.sim_sonar.pose import Transmission
from ods.sim_sonar.receiver.speckle.random_field import Keys, Normals, make_keys, normal_table
from ods.sim_sonar.receiver.speckle.speckle_law import taps
from ods.sim_sonar.sonar.model import SonarModel

STREAM = 1


class Cells(NamedTuple):
    """In which cells of the sonar's pose the rows of the field are, for two headings next to each other."""

    heading: tuple[int, int]
    heading_share: float
    """Share of the numbers that are in the second heading cell."""
    along: Ints
    """(rows, 2) cells of one range sample along the beam."""
    along_share: Normals
    """(rows, 2) how far into that cell, 0 to 1."""
    across: Normals
    """(rows, 2) m across the beam, over the beam width in radians: a cell at 1 m range."""
    time: int
    time_share: float


class Scatterers(NamedTuple):
    """Scatterers of one sonar's speckle field, for any pose."""

    keys: Keys
    """(rows, samples and a margin) of the numbers; rows are beams and a margin, plane by plane."""
    nearness: Normals
    """(samples and a margin,) 1 / range, 1/m."""
    normal: Normals
    """`normal_table`."""
    range_taps: Normals
    beam_taps: Normals
    planes: int


class SpeckleField:
    """The normal numbers behind the speckle of one sonar; `range_correlation`, `beam_correlation` of those numbers."""

    def __init__(
        self, sonar: SonarModel, seed: int, range_correlation: float, beam_correlation: float, coherence_s: float
    ) -> None:
        self._sonar = sonar
        self._coherence_s = coherence_s
        self._headings = max(1, round(2.0 * math.pi / sonar.beam_width_rad))
        range_taps, beam_taps = (taps(value).astype(np.float32) for value in (range_correlation, beam_correlation))
        margin = len(beam_taps) // 2
        bearing = sonar.plane_bearing_rad
        before = bearing[0] - sonar.beam_width_rad * np.arange(margin, 0, -1)
        after = bearing[-1] + sonar.beam_width_rad * np.arange(1, margin + 1)
        self._bearing = np.tile(np.concatenate([before, bearing, after]), sonar.planes)
        samples = sonar.samples + len(range_taps) - 1
        keys = make_keys(seed, STREAM, len(self._bearing), samples)
        ranges = sonar.range0_m + (np.arange(samples) - len(range_taps) // 2) * sonar.dr_m
        nearness = (1.0 / np.maximum(ranges, sonar.dr_m)).astype(np.float32)
        self._scatterers = Scatterers(keys, nearness, normal_table(), range_taps, beam_taps, sonar.planes)

    def at(self, sent: Transmission, area: Floats) -> Normals:
        """Return the (beams, samples) float32 normal numbers, mean 0, variance 1, that a ping sees.

        0 at ranges where no beam has any echo: `area`, (beams, samples) float64.
        """
        out = np.zeros(area.shape, np.float32)
        native.fill_speckle(self._scatterers, self._cells(*sent.pose, sent.t_s), area, out)
        return out

    def _cells(self, position_ned: Floats, attitude: Floats, t_s: float) -> Cells:
        width, turn = self._sonar.beam_width_rad, 2.0 * math.pi / self._headings
        heading = geometry.yaw_from_quat(attitude) / turn
        cell = math.floor(heading)
        # what goes up and down counts as seen at the border of the main lobe
        rise = position_ned[2] * math.sin(self._sonar.half_vertical_rad)
        # numbers are in a heading cell from 1 turn before its own heading to 1 after it, depending on their borders
        toward = self._bearing[:, None] + turn * (cell + np.array([0, 1]))
        north, east = np.cos(toward), np.sin(toward)
        along = (position_ned[0] * north + position_ned[1] * east + rise) / self._sonar.dr_m
        across = (position_ned[1] * north - position_ned[0] * east) / width
        whole = np.floor(along)
        age = t_s / self._coherence_s if self._coherence_s else 0.0
        return Cells(
            heading=(cell % self._headings, (cell + 1) % self._headings),
            heading_share=heading - cell,
            along=whole.astype(np.int64),
            along_share=(along - whole).astype(np.float32),
            across=across.astype(np.float32),
            time=math.floor(age),
            time_share=age - math.floor(age),
        )
