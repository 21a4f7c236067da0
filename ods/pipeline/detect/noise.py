"""What an image looks like where nothing is: its background level, and how much that fluctuates."""

import numpy as np

from ods.base.arrays import Floats, Image, Ints
from ods.compiled.kernel import kernel

_BINS = 1024
_SPAN = np.float32(8.0)
"""The histogram reaches to this multiple of the mean; all that is higher goes into its last bin."""
_SAMPLES = 4096
"""Cells looked at: the spread of Rayleigh speckle is then known to about 3 %."""
_FEWER = 8
"""The mean, which only sets the width of the bins, is taken of every so many-th of them."""
_NORMAL = np.array([0.5, 0.8413])
"""Quantiles that are one standard deviation apart in a normal distribution."""


class NoiseMeter:
    """Measures images of one size; has their work space."""

    def __init__(self) -> None:
        self._histogram = np.empty(_BINS, np.int64)

    def background_and_noise(self, image: Image) -> tuple[float, float]:
        """Return the median of image (beams, samples) and the distance from there to its 84 % quantile.

        For a normal distribution that distance is the standard deviation; for speckle it takes the long upper tail into
        account. Echoes that fill 1 % of the image raise it by 4 %, 5 % by a fifth. Cells at 0 hold no data and do not
        count; (0, 0) when there are no others, or when the mean is not finite.
        """
        stride = max(1, image.size // _SAMPLES) | 1  # odd: else it could fall in step with the rows
        middle, upper = quantiles(image, stride, _NORMAL, self._histogram)
        return float(middle), float(upper - middle)


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
