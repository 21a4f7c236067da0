"""From a simple ping result to what a `Ping` is made of: geometry and samples. Pure; files and live sonars share it."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import AnyArray, Floats32
from ods.sonar_link.oculus.messages import Buffer, SimpleResult
from ods.sonar_link.ping_builder import Geometry, make_beam_table

FULL_GAMMA = 255
BEARING_STEP = np.radians(0.01)
SAMPLE_TYPES: dict[int, np.dtype[np.unsignedinteger]] = {
    1: np.dtype(np.uint8),
    2: np.dtype("<u2"),
    4: np.dtype("<u4"),
}
"""By bytes a sample. The protocol knows 3, too, of undocumented layout."""
TABLE_BYTES = 2
"""Gamma is undone by a table for samples no longer than this."""


def geometry_of(result: SimpleResult, data: Buffer, at: int = 0) -> Geometry:
    """Return what a result says of its samples. Raises ValueError for what cannot be, such as bearings that fall.

    The first line's middle lies half a spacing away, as liboculus's ROS driver has it; the maker does not say.
    """
    bearing = np.frombuffer(data, "<i2", result.beams, at + result.bearings_at) * BEARING_STEP
    return Geometry(
        table=make_beam_table(bearing, np.zeros(bearing.size)),
        range0_m=0.5 * result.dr_m,
        dr_m=result.dr_m,
        sound_speed=result.sound_speed,
        frequency_hz=result.frequency_hz,
    )


def amplitudes_of(result: SimpleResult, data: Buffer, at: int = 0) -> AnyArray:
    """Return the (beams, lines) amplitudes: uint8 or uint16 as sent, float32 where gamma is undone and for 32 bits.

    A gain before a line is left out, not applied. Raises ValueError for samples of unknown layout.
    """
    dtype = SAMPLE_TYPES.get(result.sample_bytes)
    if dtype is None:
        raise ValueError(f"samples of {result.sample_bytes} bytes")
    image = np.frombuffer(data, np.uint8, result.image_bytes, at + result.image_at).reshape(result.lines, -1)
    samples = image[:, result.line_bytes - result.beams * dtype.itemsize :]
    return linear(np.ascontiguousarray(samples).view(dtype), result.fire.gamma).T


def linear(counts: NDArray[np.unsignedinteger], gamma: int) -> AnyArray:
    """Return amplitudes on the same full scale, of which the sonar sent the power `gamma` / 255."""
    long = counts.dtype.itemsize > TABLE_BYTES
    if gamma in (0, FULL_GAMMA):
        return counts.astype(np.float32) if long else counts
    full_scale, power = int(np.iinfo(counts.dtype).max), FULL_GAMMA / gamma
    if long:
        return np.asarray(full_scale * (counts / full_scale) ** power, np.float32)
    amplitudes: Floats32 = _table(full_scale, power)[counts]
    return amplitudes


@lru_cache(maxsize=4)
def _table(full_scale: int, power: float) -> Floats32:
    return np.asarray(full_scale * np.linspace(0.0, 1.0, full_scale + 1) ** power, np.float32)
