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

from ods.base import geometry
from ods.base.arrays import Floats, Ints
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.receiver.random_field import Keys, Normals, look_up, make_keys, mix
from ods.sim_sonar.receiver.speckle_law import taps
from ods.sim_sonar.sonar.model import SonarModel

STREAM = 1
OFFSETS = 1024
"""Steps in which a number's own borders are laid."""


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


class SpeckleField:
    """The normal numbers behind the speckle of one sonar; `range_correlation`, `beam_correlation` of those numbers."""

    def __init__(
        self, sonar: SonarModel, seed: int, range_correlation: float, beam_correlation: float, coherence_s: float
    ) -> None:
        self._sonar = sonar
        self._coherence_s = coherence_s
        self._headings = max(1, round(2.0 * math.pi / sonar.beam_width_rad))
        self._range_taps = taps(range_correlation).astype(np.float32)
        self._beam_taps = taps(beam_correlation).astype(np.float32)
        margin = len(self._beam_taps) // 2
        bearing = sonar.plane_bearing_rad
        before = bearing[0] - sonar.beam_width_rad * np.arange(margin, 0, -1)
        after = bearing[-1] + sonar.beam_width_rad * np.arange(1, margin + 1)
        self._bearing = np.tile(np.concatenate([before, bearing, after]), sonar.planes)
        samples = sonar.samples + len(self._range_taps) - 1
        self._keys = make_keys(seed, STREAM, len(self._bearing), samples)
        ranges = sonar.range0_m + (np.arange(samples) - len(self._range_taps) // 2) * sonar.dr_m
        self._nearness = (1.0 / np.maximum(ranges, sonar.dr_m)).astype(np.float32)

    def at(self, position_ned: Floats, attitude: Floats, t_s: float, table: Normals) -> Normals:
        """Return the (beams, samples) float32 normal numbers, mean 0, variance 1, as seen from a pose at a time."""
        out = np.zeros((self._sonar.beams, self._sonar.samples), np.float32)
        cells = self._cells(position_ned, attitude, t_s)
        _fill(self._keys, cells, self._nearness, table, self._range_taps, self._beam_taps, self._sonar.planes, out)
        return out

    def _cells(self, position_ned: Floats, attitude: Floats, t_s: float) -> Cells:
        width, turn = self._sonar.beam_width_rad, 2.0 * math.pi / self._headings
        _, _, yaw = geometry.euler_from_quat(attitude)
        heading = float(yaw) / turn
        cell = math.floor(heading)
        # what goes up and down counts as seen at the border of the main lobe
        rise = position_ned[2] * math.sin(self._sonar.half_vertical_rad)
        toward = self._bearing[:, None] + turn * (cell + np.array([-0.5, 0.5]))
        along = (position_ned[0] * np.cos(toward) + position_ned[1] * np.sin(toward) + rise) / self._sonar.dr_m
        across = (position_ned[1] * np.cos(toward) - position_ned[0] * np.sin(toward)) / width
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


@compiled
def _fill(
    keys: Keys,
    cells: Cells,
    nearness: Normals,
    table: Normals,
    range_taps: Normals,
    beam_taps: Normals,
    planes: int,
    out: Normals,
) -> None:
    """Add the filtered field to `out` (beams, samples), which is zero."""
    rows, beams = len(keys) // planes, len(out) // planes
    raw, bits = np.empty(keys.shape[1], np.float32), np.empty(keys.shape[1], np.uint32)
    smooth = np.empty(out.shape[1], np.float32)
    for plane in range(planes):
        for row in range(rows):
            _draw(keys[plane * rows + row], cells, plane * rows + row, nearness, table, bits, raw)
            smooth[:] = 0.0
            for k in range(len(range_taps)):
                _add(smooth, range_taps[k], raw[k : k + len(smooth)])
            for k in range(len(beam_taps)):
                beam = row - k
                if 0 <= beam < beams:
                    _add(out[plane * beams + beam], beam_taps[k], smooth)


@compiled
def _add(target: Normals, factor: np.float32, source: Normals) -> None:
    for j in range(len(target)):
        target[j] += factor * source[j]


@compiled
def _draw(keys: Keys, cells: Cells, row: int, nearness: Normals, table: Normals, bits: Keys, out: Normals) -> None:
    """Set `out` to the numbers of one row: each key, with the cells it is in, hashed and looked up."""
    _hash(
        keys, bits, nearness,
        np.uint32(cells.heading[0]), np.uint32(cells.heading[1]), np.uint32(cells.heading_share * OFFSETS),
        np.uint32(cells.along[row, 0]), np.uint32(cells.along[row, 1]),
        cells.along_share[row, 0], cells.along_share[row, 1],
        cells.across[row, 0], cells.across[row, 1],
        np.uint32(cells.time), np.uint32((1.0 - cells.time_share) * OFFSETS),
    )  # fmt: skip
    look_up(bits, table, out)


@compiled
def _hash(
    keys: Keys, bits: Keys, nearness: Normals, heading: np.uint32, next_heading: np.uint32, turned: np.uint32,
    along_0: np.uint32, along_1: np.uint32, share_0: np.float32, share_1: np.float32,
    across_0: np.float32, across_1: np.float32, time: np.uint32, young: np.uint32,
) -> None:  # fmt: skip
    """Set `bits` to the hash of key and cells; 32-bit arithmetic throughout, or the loop is three times slower.

    Ten bits of a key each lay its own borders in heading, along, and across the beam; others in time.
    """
    mask, step = np.uint32(OFFSETS - 1), np.float32(1.0 / OFFSETS)
    for j in range(len(bits)):
        key = keys[j]
        second = (key & mask) < turned
        own_along = np.float32(np.int32((key >> np.uint32(10)) & mask)) * step
        own_across = np.float32(np.int32((key >> np.uint32(20)) & mask)) * step
        own_time = np.uint32(key * np.uint32(0x9E3779B1)) >> np.uint32(22)
        further = np.uint32(np.int32((share_1 if second else share_0) + own_along))
        along = np.uint32((along_1 if second else along_0) + further)
        side = (across_1 if second else across_0) * nearness[j] + own_across
        across = np.uint32(np.int32(np.floor(side)))
        turn = next_heading if second else heading
        age = np.uint32(time + np.uint32(1)) if own_time >= young else time
        cell = np.uint32(np.uint32(along * np.uint32(0x85EBCA6B)) + np.uint32(across * np.uint32(0xC2B2AE35)))
        cell = np.uint32(cell + np.uint32(turn * np.uint32(0x27D4EB2F)))
        cell = np.uint32(cell + np.uint32(age * np.uint32(0x165667B1)))
        bits[j] = mix(np.uint32(mix(np.uint32(key + cell)) ^ key))
