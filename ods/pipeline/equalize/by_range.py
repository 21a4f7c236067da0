"""Equalization by range: the average at each range is brought to 1 [SSIE, Image processing, stage 1]."""

import numpy as np

from ods.base.arrays import AnyArray, Floats32, Image, Ints, Ints32
from ods.base.kernel import kernel
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, GainStep, load_row
from ods.pipeline.stage.params import MeanRangeParams, MedianRangeParams
from ods.pipeline.stage.registry import image_stage

_BLOCK = 32
"""Columns that share one value of the surroundings' level."""
_HALVINGS = 10
"""Steps of the search for the median: it is known to 0.2 % of the mean."""


@image_stage("equalize.mean_range", MeanRangeParams)
def mean_range(params: MeanRangeParams, fan: Fan) -> GainStep:
    """Divide each range by its mean over the beams, but never by more than `guard` times its surroundings' mean.

    The guard is what keeps a wall, which fills the sector at its range, from erasing itself; slow changes, belts wider
    than half the window and drop-outs are levelled in full. Side lobes of a strong echo are levelled out of the other
    beams. A range of zeros stays zero.
    """
    columns = ColumnSums(fan)
    limiter = Limiter(params, fan)
    side_lobe = np.float32(10.0 ** (-params.side_lobe_db / 20.0))
    beams = len(fan.bearing_rad)
    level = np.empty(fan.samples, np.float32)
    gain = np.empty((1, fan.samples), np.float32)

    def regain(samples: GainedImage) -> GainedImage:
        sums, highest, offset = columns.measure(samples)
        means_to_gain(sums, beams, highest, offset, side_lobe, *limiter.args, level, samples.gain[0], gain[0])
        return samples.with_column_gain(gain)

    return GainStep(regain)


@image_stage("equalize.median_range", MedianRangeParams)
def median_range(params: MedianRangeParams, fan: Fan) -> GainStep:
    """Divide each range by its median over the beams: what fills less than half of the sector does not count.

    The median is brought to the mean that speckle has (1.064 of the median of a Rayleigh distribution).
    """
    columns = ColumnSums(fan)
    limiter = Limiter(params, fan)
    beams = len(fan.bearing_rad)
    level = np.empty(fan.samples, np.float32)
    work = np.empty((4, fan.samples), np.float32)
    gain = np.empty((1, fan.samples), np.float32)

    def regain(samples: GainedImage) -> GainedImage:
        sums, _, offset = columns.measure(samples)
        means_of(sums, beams, offset, level)
        column_medians(*samples.args, level, work)
        np.multiply(level, np.float32(1.064), out=level)
        limit_levels(level, *limiter.args)
        to_gain(level, samples.gain[0], gain[0])
        return samples.with_column_gain(gain)

    return GainStep(regain)


class Limiter:
    """The guard: levels are limited to a multiple of those around."""

    def __init__(self, params: MeanRangeParams | MedianRangeParams, fan: Fan) -> None:
        reach = max(1, params.window // (2 * _BLOCK))
        self._guard = np.float32(params.guard)
        self._blocks = np.empty(-(-fan.samples // _BLOCK), np.float32)
        self._nearby = np.empty(2 * reach + 1, np.float32)

    @property
    def args(self) -> tuple[np.float32, Floats32, Floats32]:
        """What `limit_levels` takes behind the level."""
        return self._guard, self._blocks, self._nearby


class ColumnSums:
    """Sum and maximum over the beams; recorded counts are summed as integers, four times as fast as amplitudes."""

    def __init__(self, fan: Fan) -> None:
        self._fan = fan
        self._row = np.empty(fan.samples, np.float32)
        self._total = np.empty(fan.samples, np.float32)
        self._highest = np.empty(fan.samples, np.float32)
        self._counts: dict[np.dtype[np.generic], tuple[AnyArray, AnyArray]] = {}

    def measure(self, samples: GainedImage) -> tuple[AnyArray, AnyArray, np.float32]:
        """Return sum and maximum of each column, (samples,), and what is to be added to each cell.

        The arrays are reused by the next call.
        """
        cells = samples.cells
        if samples.plain and cells.dtype.kind == "u":
            sums, highest = self._buffers(cells.dtype)
            add_columns(cells, samples.first, sums, highest)
            return sums, highest, samples.offset
        bits = np.int32
        row, highest = self._row, self._highest
        add_amplitudes(*samples.args, row, row.view(bits), self._total, highest.view(bits))
        return self._total, highest, np.float32(0.0)

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
def add_amplitudes(
    cells: AnyArray,
    first: int,
    offset: np.float32,
    gain: Image,
    above: Ints,
    share: Floats32,
    row: Floats32,
    row_bits: Ints32,
    total: Floats32,
    highest_bits: Ints32,
) -> None:
    """Fill total and highest (samples,) with sum and maximum over the beams of samples (`GainedImage.args`).

    row_bits and highest_bits are the bits of row and highest: floats that are not negative are in the order of their
    bits, and a maximum of integers vectorises.
    """
    total[:] = np.float32(0.0)
    highest_bits[:] = 0
    for b in range(above.size):
        load_row(cells, first, offset, gain, above, share, b, row)
        for j in range(total.size):
            total[j] += row[j]
        for j in range(total.size):
            highest_bits[j] = max(highest_bits[j], row_bits[j])


@kernel
def means_of(sums: AnyArray, beams: int, offset: np.float32, level: Floats32) -> None:
    """Fill level (samples,) with sums / beams + offset."""
    share = np.float32(1.0 / beams)
    for j in range(level.size):
        level[j] = np.float32(sums[j]) * share + offset


@kernel
def means_to_gain(
    sums: AnyArray,
    beams: int,
    highest: AnyArray,
    offset: np.float32,
    side_lobe: np.float32,
    guard: np.float32,
    blocks: Floats32,
    nearby: Floats32,
    level: Floats32,
    before: Floats32,
    gain: Floats32,
) -> None:
    """Fill gain (samples,) with before / level, the level being the mean, as `limit_levels` limits it.

    Where side_lobe * (highest + offset) is higher, that is the level. level (samples,), blocks and nearby are work
    space.
    """
    means_of(sums, beams, offset, level)
    limit_levels(level, guard, blocks, nearby)
    for j in range(level.size):
        lobe = side_lobe * (np.float32(highest[j]) + offset)
        level[j] = lobe if lobe > level[j] else level[j]
    to_gain(level, before, gain)


@kernel
def column_medians(
    cells: AnyArray,
    first: int,
    offset: np.float32,
    gain: Image,
    above: Ints,
    share: Floats32,
    level: Floats32,
    work: Image,
) -> None:
    """Turn level (samples,), the means, into the medians over the beams of samples (`GainedImage.args`).

    By halving an interval: the median of what is not negative is at most twice the mean. work: (4, samples).
    """
    low, high, count, row = work[0], work[1], work[2], work[3]
    beams = above.size
    half = np.float32(0.5 * beams)
    for j in range(level.size):
        low[j], high[j] = np.float32(0.0), np.float32(2.0) * level[j]
    for _ in range(_HALVINGS):
        for j in range(level.size):
            level[j] = np.float32(0.5) * (low[j] + high[j])
            count[j] = np.float32(0.0)
        for b in range(beams):
            load_row(cells, first, offset, gain, above, share, b, row)
            for j in range(level.size):
                count[j] += np.float32(1.0) if row[j] > level[j] else np.float32(0.0)
        for j in range(level.size):
            low[j], high[j] = (level[j], high[j]) if count[j] >= half else (low[j], level[j])


@kernel
def limit_levels(level: Floats32, guard: np.float32, blocks: Floats32, nearby: Floats32) -> None:
    """Limit level (samples,) to guard times its surroundings' level, in place.

    The surroundings' level is the median of block means over nearby.size blocks around, so an edge of a belt keeps its
    place. blocks (ceil(samples / 32),) and nearby (odd,) are work space.
    """
    count = blocks.size
    for k in range(count):
        part = level[k * _BLOCK : (k + 1) * _BLOCK]
        total = np.float32(0.0)
        for j in range(part.size):
            total += part[j]
        blocks[k] = total / np.float32(part.size)
    reach = nearby.size // 2
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
