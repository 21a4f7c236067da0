"""From an image packet to what a `Ping` is made of: geometry and samples. Pure; files and live sonars share it."""

from functools import lru_cache

import numpy as np

from ods.base.arrays import AnyArray
from ods.sonar_link.norbit.packets import DIRECTION_BYTES, IMAGE_AT, SAMPLE_TYPES, Buffer, ImageHead
from ods.sonar_link.ping_builder import BeamTable, Geometry, make_beam_table

PLAIN = (np.dtype(np.uint8), np.dtype("<u2"), np.dtype("<f4"))
"""Sample types that a `Ping` has, too."""
CACHE_LINE_BYTES = 64
UNSIGNED: dict[np.dtype[np.generic], str] = {np.dtype("i1"): "u1", np.dtype("<i2"): "<u2"}
"""What amplitudes of short signed samples become."""


def geometry_of(head: ImageHead, data: Buffer, at: int = 0) -> Geometry:
    """Return what a packet says of its samples. Raises ValueError for what cannot be, such as bearings that repeat.

    Sample i lies (first + i) c / (2 fs) away; samples before transmission are left out.
    """
    start = at + head.directions_at
    elevation_rad = head.elevation_rad if head.elevation_rad == head.elevation_rad else 0.0  # NaN: not reported
    return Geometry(
        table=_table(bytes(data[start : start + DIRECTION_BYTES * head.beams]), elevation_rad),
        range0_m=max(head.first_sample, 0) * _spacing_m(head),
        dr_m=_spacing_m(head),
        sound_speed=head.sound_speed,
        frequency_hz=head.frequency_hz,
    )


def amplitudes_of(head: ImageHead, data: Buffer, at: int = 0) -> AnyArray:
    """Return the (beams, samples) amplitudes: uint8, uint16 and float32 as sent, short signed ones as unsigned, others
    as float32; below 0 is 0 there. Beams run to starboard, as the bearings of `geometry_of` do.

    Raises ValueError when all samples precede the transmission.
    """
    dtype = SAMPLE_TYPES[head.sample_type]
    lines = np.frombuffer(data, dtype, head.beams * head.samples, at + IMAGE_AT).reshape(head.samples, head.beams)
    lines = lines[max(-head.first_sample, 0) :]
    if not lines.size:
        raise ValueError("all samples precede the transmission")
    if dtype not in PLAIN:
        lines = np.maximum(lines, 0).astype(UNSIGNED.get(dtype, "<f4"))
    start = at + head.directions_at
    first, last = np.frombuffer(data, "<f4", head.beams, start)[[0, -1]]
    beams = _turned(lines)
    return beams if first <= last else beams[::-1]


def _turned(lines: AnyArray) -> AnyArray:
    """Return the transposed array, in memory order: by as many lines at a time as fill a cache line of the result."""
    beams = np.empty(lines.shape[::-1], lines.dtype)
    step = CACHE_LINE_BYTES // lines.dtype.itemsize
    for first in range(0, len(lines), step):
        beams[:, first : first + step] = lines[first : first + step].T
    return beams


def _spacing_m(head: ImageHead) -> float:
    if not head.sample_rate_hz > 0.0:
        raise ValueError(f"sample rate: {head.sample_rate_hz:g} Hz")
    return head.sound_speed / (2.0 * head.sample_rate_hz)


@lru_cache(maxsize=8)
def _table(directions: bytes, elevation_rad: float) -> BeamTable:
    """Return the beams in rising order: those of a sonar that counts from starboard come the other way round."""
    bearing = np.frombuffer(directions, "<f4").astype(np.float64)
    rising = bearing if bearing[0] <= bearing[-1] else bearing[::-1]
    return make_beam_table(rising, np.full(bearing.size, elevation_rad))
