"""Equalization by range, `mean_range` and `median_range`: the average there is brought to 1 [SSIE, Image processing,
stage 1]."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats32, Image, Ints32
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, load_row
from ods.pipeline.stage.params import MeanRangeParams, MedianRangeParams
from ods.pipeline.stage.registry import gain_stage
from ods.pipeline.stage.step import GainStep

_BLOCK = 32
"""Columns that share one value of the surroundings' level."""
_HALVINGS = 10
"""Steps of the search for the median: it is known to 0.2 % of the mean."""


@gain_stage("equalize.mean_range", MeanRangeParams)
def mean_range(params: MeanRangeParams, fan: Fan) -> GainStep:
    """Divide each range by its mean over the beams, but never by more than `guard` times its surroundings' mean.

    The guard is what keeps a wall, which fills the sector at its range, from erasing itself; slow changes, belts wider
    than half the window and drop-outs are levelled in full. Side lobes of a strong echo are levelled out of the other
    beams. A range of zeros stays zero.
    """
    meter = ColumnMeter(fan)
    guard, reach = np.float32(params.guard), blocks_around(params.window)
    side_lobe = np.float32(10.0 ** (-params.side_lobe_db / 20.0))
    gain = np.empty((1, fan.samples), np.float32)

    def step(image: GainedImage) -> GainedImage:
        means_to_gain(meter.measure(image), side_lobe, guard, reach, image.gain[0], gain[0])
        return image.with_column_gain(gain)

    return step


@gain_stage("equalize.median_range", MedianRangeParams)
def median_range(params: MedianRangeParams, fan: Fan) -> GainStep:
    """Divide each range by its median over the beams: what fills less than half of the sector does not count.

    The median is brought to the mean that speckle has (1.064 of the median of a Rayleigh distribution).
    """
    meter = ColumnMeter(fan)
    guard, reach = np.float32(params.guard), blocks_around(params.window)
    level = np.empty(fan.samples, np.float32)
    work = np.empty((4, fan.samples), np.float32)
    gain = np.empty((1, fan.samples), np.float32)

    def step(image: GainedImage) -> GainedImage:
        means_of(meter.measure(image), level)
        column_medians(image, level, work)
        np.multiply(level, np.float32(1.064), out=level)
        limit_levels(level, guard, reach)
        to_gain(level, image.gain[0], gain[0])
        return image.with_column_gain(gain)

    return step


def blocks_around(window: int) -> int:
    """Return how many blocks to either side of a range make surroundings of `window` range samples."""
    return max(1, window // (2 * _BLOCK))


class ColumnSums(NamedTuple):
    """What the columns of an image add up to; `offset` is to be added to each cell."""

    sums: AnyArray
    """(samples,)."""
    highest: AnyArray
    """(samples,)."""
    beams: int
    offset: np.float32


class ColumnMeter:
    """Sum and maximum over the beams; recorded counts are summed as integers, four times as fast as amplitudes."""

    def __init__(self, fan: Fan) -> None:
        self._fan = fan
        self._row = np.empty(fan.samples, np.float32)
        self._total = np.empty(fan.samples, np.float32)
        self._highest = np.empty(fan.samples, np.float32)
        self._counts: dict[np.dtype[np.generic], tuple[AnyArray, AnyArray]] = {}

    def measure(self, image: GainedImage) -> ColumnSums:
        """Return sum and maximum of each column; the arrays are reused by the next call."""
        beams = len(self._fan.bearing_rad)
        if image.plain and image.cells.dtype.kind == "u":
            sums, highest = self._buffers(image.cells.dtype)
            add_columns(image.cells, image.first, sums, highest)
            return ColumnSums(sums, highest, beams, image.offset)
        bits = np.int32
        add_amplitudes(image, self._row, self._row.view(bits), self._total, self._highest.view(bits))
        return ColumnSums(self._total, self._highest, beams, np.float32(0.0))

    def _buffers(self, dtype: np.dtype[np.generic]) -> tuple[AnyArray, AnyArray]:
        if dtype not in self._counts:
            narrow = dtype.itemsize == 1 and self._fan.shape[0] <= 257  # 257 * 255 is the largest uint16
            sums = np.empty(self._fan.samples, np.uint16 if narrow else np.uint32)
            self._counts[dtype] = (sums, np.empty(self._fan.samples, dtype))
        return self._counts[dtype]


@kernel
def add_columns(cells: AnyArray, first: int, sums: AnyArray, highest: AnyArray) -> None:
    """Fill sums and highest (samples,) with sum and maximum over the beams of unsigned cells[:, first:]."""
    sums[:] = 0
    highest[:] = 0
    for b in range(cells.shape[0]):
        row = cells[b, first:]
        for j in range(sums.size):
            sums[j] += row[j]
        for j in range(sums.size):
            highest[j] = max(highest[j], row[j])


@kernel
def add_amplitudes(image: GainedImage, row: Floats32, row_bits: Ints32, total: Floats32, highest_bits: Ints32) -> None:
    """Fill total and highest (samples,) with sum and maximum over the beams of the image.

    row_bits and highest_bits are the bits of row and highest: floats that are not negative are in the order of their
    bits, and a maximum of integers vectorises.
    """
    total[:] = np.float32(0.0)
    highest_bits[:] = 0
    for b in range(image.above.size):
        load_row(image, b, row)
        for j in range(total.size):
            total[j] += row[j]
        for j in range(total.size):
            highest_bits[j] = max(highest_bits[j], row_bits[j])


@kernel
def means_of(columns: ColumnSums, level: Floats32) -> None:
    """Fill level (samples,) with the means."""
    share = np.float32(1.0 / columns.beams)
    for j in range(level.size):
        level[j] = np.float32(columns.sums[j]) * share + columns.offset


@kernel
def means_to_gain(
    columns: ColumnSums, side_lobe: np.float32, guard: np.float32, reach: int, before: Floats32, gain: Floats32
) -> None:
    """Fill gain (samples,) with before / level, the level being the mean, as `limit_levels` limits it.

    Where side_lobe times the highest amplitude is higher, that is the level.
    """
    level = np.empty_like(gain)
    means_of(columns, level)
    limit_levels(level, guard, reach)
    for j in range(level.size):
        lobe = side_lobe * (np.float32(columns.highest[j]) + columns.offset)
        level[j] = lobe if lobe > level[j] else level[j]
    to_gain(level, before, gain)


@kernel
def column_medians(image: GainedImage, level: Floats32, work: Image) -> None:
    """Turn level (samples,), the means, into the medians over the beams of the image.

    By halving an interval: the median of what is not negative is at most twice the mean. work: (4, samples).
    """
    low, high, count, row = work[0], work[1], work[2], work[3]
    beams = image.above.size
    half = np.float32(0.5 * beams)
    for j in range(level.size):
        low[j], high[j] = np.float32(0.0), np.float32(2.0) * level[j]
    for _ in range(_HALVINGS):
        for j in range(level.size):
            level[j] = np.float32(0.5) * (low[j] + high[j])
            count[j] = np.float32(0.0)
        for b in range(beams):
            load_row(image, b, row)
            for j in range(level.size):
                count[j] += np.float32(1.0) if row[j] > level[j] else np.float32(0.0)
        for j in range(level.size):
            low[j], high[j] = (level[j], high[j]) if count[j] >= half else (low[j], level[j])


@kernel
def limit_levels(level: Floats32, guard: np.float32, reach: int) -> None:
    """Limit level (samples,) to guard times its surroundings' level, in place.

    The surroundings' level is the median of block means over `reach` blocks to either side, so an edge of a belt keeps
    its place.
    """
    count = (level.size + _BLOCK - 1) // _BLOCK
    blocks, nearby = np.empty(count, np.float32), np.empty(2 * reach + 1, np.float32)
    for k in range(count):
        part = level[k * _BLOCK : (k + 1) * _BLOCK]
        total = np.float32(0.0)
        for j in range(part.size):
            total += part[j]
        blocks[k] = total / np.float32(part.size)
    for k in range(count):
        first, last = max(0, k - reach), min(count, k + reach + 1)
        limit = guard * sorted_middle(blocks[first:last], nearby)
        part = level[k * _BLOCK : (k + 1) * _BLOCK]
        for j in range(part.size):
            part[j] = min(part[j], limit)


@kernel
def sorted_middle(values: Floats32, work: Floats32) -> np.float32:
    """Return the (lower) median of a few values; work has room for them."""
    for i in range(values.size):
        value = values[i]
        k = i
        while k > 0 and work[k - 1] > value:
            work[k] = work[k - 1]
            k -= 1
        work[k] = value
    return np.float32(work[(values.size - 1) // 2])


@kernel
def to_gain(level: Floats32, before: Floats32, gain: Floats32) -> None:
    """Fill gain (samples,) with before / level; 0 where the level is 0."""
    for j in range(level.size):  # three loops, as a division under a condition does not vectorise
        gain[j] = level[j] if level[j] > np.float32(0.0) else np.float32(1.0)
    for j in range(level.size):
        gain[j] = before[j] / gain[j]
    for j in range(level.size):
        gain[j] = gain[j] if level[j] > np.float32(0.0) else np.float32(0.0)
