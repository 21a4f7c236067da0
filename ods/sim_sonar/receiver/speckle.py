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
from ods.sim_sonar.pose import Transmission
from ods.sim_sonar.receiver.random_field import Keys, Normals, hash32, make_keys, normal_table, normals_of
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


class Scatterers(NamedTuple):
    """What the field of one sonar is made of, whatever its pose."""

    keys: Keys
    """(rows, samples and a margin) of the numbers; rows are beams and a margin, plane by plane."""
    nearness: Normals
    """(samples and a margin,) 1 / range, 1/m."""
    normal: Normals
    """`normal_table`."""
    range_taps: Normals
    beam_taps: Normals
    planes: int


class RowCells(NamedTuple):
    """The cells of one row of the field, as its hash takes them: 32 bits throughout, or it is three times slower."""

    heading: np.uint32
    next_heading: np.uint32
    turned: np.uint32
    """Share of OFFSETS that is in the next heading cell."""
    along: np.uint32
    next_along: np.uint32
    """In the next heading cell; likewise below."""
    along_share: np.float32
    next_along_share: np.float32
    across: np.float32
    next_across: np.float32
    time: np.uint32
    young: np.uint32
    """Share of OFFSETS from which on a number is in the next time cell."""


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

    def at(self, sent: Transmission) -> Normals:
        """Return the (beams, samples) float32 normal numbers, mean 0, variance 1, that a ping sees."""
        out = np.zeros((self._sonar.beams, self._sonar.samples), np.float32)
        _fill(self._scatterers, self._cells(*sent.pose, sent.t_s), out)
        return out

    def _cells(self, position_ned: Floats, attitude: Floats, t_s: float) -> Cells:
        width, turn = self._sonar.beam_width_rad, 2.0 * math.pi / self._headings
        _, _, yaw = geometry.euler_from_quat(attitude)
        heading = float(yaw) / turn
        cell = math.floor(heading)
        # what goes up and down counts as seen at the border of the main lobe
        rise = position_ned[2] * math.sin(self._sonar.half_vertical_rad)
        # numbers are in a heading cell from 1 turn before its own heading to 1 after it, depending on their borders
        toward = self._bearing[:, None] + turn * (cell + np.array([0, 1]))
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
def _fill(scatterers: Scatterers, cells: Cells, out: Normals) -> None:
    """Add the filtered field to `out` (beams, samples), which is zero."""
    planes, range_taps, beam_taps = scatterers.planes, scatterers.range_taps, scatterers.beam_taps
    rows, samples = len(scatterers.keys) // planes, scatterers.keys.shape[1]
    beams = len(out) // planes
    raw, bits = np.empty(samples, np.float32), np.empty(samples, np.uint32)
    smooth = np.empty(out.shape[1], np.float32)
    for plane in range(planes):
        for row in range(rows):
            _draw(scatterers, cells, plane * rows + row, bits, raw)
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
def _draw(scatterers: Scatterers, cells: Cells, row: int, bits: Keys, out: Normals) -> None:
    """Set `out` to the numbers of one row: each key, with the cells it is in, hashed and looked up."""
    mine = RowCells(
        heading=np.uint32(cells.heading[0]),
        next_heading=np.uint32(cells.heading[1]),
        turned=np.uint32(cells.heading_share * OFFSETS),
        along=np.uint32(cells.along[row, 0]),
        next_along=np.uint32(cells.along[row, 1]),
        along_share=cells.along_share[row, 0],
        next_along_share=cells.along_share[row, 1],
        across=cells.across[row, 0],
        next_across=cells.across[row, 1],
        time=np.uint32(cells.time),
        young=np.uint32((1.0 - cells.time_share) * OFFSETS),
    )
    _hash(scatterers.keys[row], mine, scatterers.nearness, bits)
    normals_of(bits, scatterers.normal, out)


@compiled
def _hash(keys: Keys, cells: RowCells, nearness: Normals, bits: Keys) -> None:
    """Set `bits` to the hash of key and cells.

    Ten bits of a key each lay its own borders in heading, along, and across the beam; others in time.
    """
    mask, step = np.uint32(OFFSETS - 1), np.float32(1.0 / OFFSETS)
    for j in range(len(bits)):
        key = keys[j]
        second = (key & mask) < cells.turned
        own_along = np.float32(np.int32((key >> np.uint32(10)) & mask)) * step
        own_across = np.float32(np.int32((key >> np.uint32(20)) & mask)) * step
        own_time = np.uint32(key * np.uint32(0x9E3779B1)) >> np.uint32(22)
        further = np.uint32(np.int32((cells.next_along_share if second else cells.along_share) + own_along))
        along = np.uint32((cells.next_along if second else cells.along) + further)
        side = (cells.next_across if second else cells.across) * nearness[j] + own_across
        across = np.uint32(np.int32(np.floor(side)))
        turn = cells.next_heading if second else cells.heading
        age = np.uint32(cells.time + np.uint32(1)) if own_time >= cells.young else cells.time
        cell = np.uint32(np.uint32(along * np.uint32(0x85EBCA6B)) + np.uint32(across * np.uint32(0xC2B2AE35)))
        cell = np.uint32(cell + np.uint32(turn * np.uint32(0x27D4EB2F)))
        cell = np.uint32(cell + np.uint32(age * np.uint32(0x165667B1)))
        bits[j] = hash32(np.uint32(hash32(np.uint32(key + cell)) ^ key))
