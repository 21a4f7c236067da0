"""What an image looks like where nothing is: its background level, how much that fluctuates, and how high it peaks."""

from collections.abc import Iterable

import numpy as np

from ods.base.arrays import Floats, Image, Ints
from ods.compiled.kernel import kernel

_BINS = 1024
_FINE_BINS = 16384
_SPAN = np.float32(8.0)
"""The histogram reaches to this multiple of the mean; all that is higher goes into its last bin."""
_SAMPLES = 4096
"""Cells looked at: the spread of Rayleigh speckle is then known to about 3 %."""
_FEWER = 8
"""The mean, which only sets the width of the bins, is taken of every so many-th of them."""
_BULK = np.array([0.5, 0.9, 0.99])
"""Quantiles by which an image is compared with speckle: echoes may fill some tenths of a per cent of it."""
_NORMAL = np.array([0.5, 0.8413])
"""Quantiles that are one standard deviation apart in a normal distribution."""
_TAIL = np.array([0.01, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5])
"""Shares of the cells of speckle that its tail is fitted at, each weighted by the fourth root of the share."""


class NoiseMeter:
    """Measures images of one size; has their work space."""

    def __init__(self) -> None:
        self._histogram = np.empty(_BINS, np.int64)
        self._fine = np.empty(_FINE_BINS, np.int64)
        self._of_speckle = np.log(np.sqrt(-2.0 * np.log(1.0 - _BULK)))
        self._tail = np.array([0.0, 0.5, 0.5 * np.log(2.0)])

    def background_and_noise(self, image: Image) -> tuple[float, float]:
        """Return the median of image (beams, samples) and the distance from there to its 84 % quantile.

        For a normal distribution that distance is the standard deviation; for speckle it takes the long upper tail into
        account. Echoes that fill 1 % of the image raise it by 4 %, 5 % by a fifth. Cells at 0 hold no data and do not
        count; (0, 0) when there are no others, or when the mean is not finite.
        """
        stride = max(1, image.size // _SAMPLES) | 1  # odd: else it could fall in step with the rows
        middle, upper = quantiles(image, stride, _NORMAL, self._histogram)
        return float(middle), float(upper - middle)

    def learn(self, images: Iterable[Image]) -> None:
        """Take in the shape of the upper tail of images without echoes, all from the same chain.

        What is not known of it before is that of speckle as it is: Rayleigh.
        """
        total = np.zeros(_FINE_BINS, np.int64)
        unit = 0.0
        for image in images:
            unit = unit or bins_in_unit(image, 1, total)
            fill_histogram(image, 1, unit, self._fine)
            total += self._fine
        if not unit:
            return
        ranks = np.concatenate([1.0 - _TAIL, _BULK]) * total.sum()
        at = np.log([quantile(total, rank) for rank in ranks])
        self._of_speckle = at[len(_TAIL) :]
        self._tail = np.polyfit(np.log(-np.log(_TAIL)), at[: len(_TAIL)], 2, w=_TAIL**0.25)

    def level_of_rate(self, image: Image, rate: float) -> float:
        """Return the level that a share `rate` of the cells without echoes exceeds.

        The image is taken for speckle of the shape learnt, raised to a power and times a factor, both fitted to its own
        quantiles; the tail of the speckle is x = exp(a + b w + c w^2), w = log(-log(share)), which for Rayleigh
        distributed amplitudes holds with b = 1/2 and c = 0.
        """
        own = np.log(quantiles(image, 1, _BULK, self._fine))
        power, factor = np.polyfit(self._of_speckle, own, 1)
        level = np.exp(factor + power * np.polyval(self._tail, np.log(-np.log(rate))))
        return float(max(level, np.exp(own[-1])))


@kernel
def quantiles(image: Image, stride: int, shares: Floats, histogram: Ints) -> Floats:
    """Return quantiles (shares,) of every stride-th cell of image that is above 0; zeros when there is none.

    histogram: work space.
    """
    out = np.zeros(shares.size)
    unit = bins_in_unit(image, stride, histogram)
    if unit > 0.0:
        count = fill_histogram(image, stride, unit, histogram)
        for i in range(shares.size):
            out[i] = quantile(histogram, shares[i] * count) / unit
    return out


@kernel
def bins_in_unit(image: Image, stride: int, histogram: Ints) -> float:
    """Return the bins that an amplitude of 1 is worth, by the mean of some cells above 0; 0 where it is not finite."""
    cells = image.reshape(image.size)
    for step in (_FEWER * stride, stride):
        total, count = np.float32(0.0), np.float32(0.0)
        for i in range(0, cells.size, step):
            positive = cells[i] > np.float32(0.0)
            total += cells[i] if positive else np.float32(0.0)
            count += np.float32(1.0) if positive else np.float32(0.0)
        if count > np.float32(0.0):
            mean = float(total / count)
            return histogram.size / (float(_SPAN) * mean) if np.isfinite(mean) else 0.0
    return 0.0


@kernel
def fill_histogram(image: Image, stride: int, unit: float, histogram: Ints) -> int:
    """Count every stride-th cell above 0 into a histogram of bins of 1 / unit; return how many there are."""
    cells = image.reshape(image.size)
    histogram[:] = 0
    scale, last = np.float32(unit), np.float32(histogram.size - 1)
    count = 0
    for i in range(0, cells.size, stride):
        place = cells[i] * scale
        positive = 1 if place > np.float32(0.0) else 0  # 0 for NaN
        histogram[np.int32(place if place < last else last)] += positive
        count += positive
    return count


@kernel
def quantile(histogram: Ints, rank: float) -> float:
    """Return where the running sum of the histogram reaches `rank`, in bins, interpolated."""
    below = 0
    for k in range(histogram.size):
        if below + histogram[k] >= rank:
            return float(k + (rank - below) / max(1, histogram[k]))
        below += histogram[k]
    return float(histogram.size)
