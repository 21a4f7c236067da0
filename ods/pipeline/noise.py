"""What an image looks like where nothing is: its background level, how much that fluctuates, and how high it peaks."""

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from ods.pipeline.fan import Image
from ods.pipeline.kernel import kernel
from ods.pipeline.mirror import Row

_BINS = 1024
_FINE_BINS = 16384
_SPAN = np.float32(8.0)
"""The histogram reaches to this multiple of the mean; all that is higher goes into its last bin."""
_SAMPLES = 4096
"""Cells looked at: the spread of Rayleigh speckle is then known to about 3 %."""
_TAIL_SAMPLES = 65536
_UPPER = 0.8413
"""Quantile one standard deviation above the middle of a normal distribution."""
_TAIL = (0.5, 0.9, 0.99)
"""Quantiles from which the tail is extrapolated: echoes may fill some tenths of a per cent of an image."""
_POWER = 0.5
"""Amplitudes to this power are close to normal. 2/3 would do for speckle as it is (E. B. Wilson, M. M. Hilferty, PNAS
17, 1931); a little less fits the tail of filtered speckle better."""


class NoiseMeter:
    """Measures images of one size; has their work space."""

    def __init__(self) -> None:
        self._picked = np.empty(0, np.float32)
        self._histogram = np.empty(_BINS, np.int64)
        self._fine = np.empty(_FINE_BINS, np.int64)
        normal = NormalDist()
        self._z = np.array([normal.inv_cdf(share) for share in _TAIL])

    def background_and_noise(self, image: Image) -> tuple[float, float]:
        """Return the median of image (beams, samples) and the distance from there to its 84 % quantile.

        For a normal distribution that distance is the standard deviation; for speckle it takes the long upper tail into
        account. Echoes that fill 1 % of the image raise it by 4 %, 5 % by a fifth. Cells at 0 hold no data and do not
        count; (0, 0) when there are no others, or when the mean is not finite.
        """
        middle, upper = self._quantiles(image, _SAMPLES, self._histogram, (0.5, _UPPER))
        return middle, upper - middle

    def level_of_rate(self, image: Image, rate: float) -> float:
        """Return the level that a share `rate` of the cells without echoes exceeds.

        Speckle that was filtered, whatever the sonar and the sample type, is brought close to normal by a power; the
        rest of its shape is taken from three quantiles of the image: x^(1/2) = a + b z + c z^2, z the normal deviate.
        """
        quantiles = np.array(self._quantiles(image, _TAIL_SAMPLES, self._fine, _TAIL)) ** _POWER
        c, b, a = np.polyfit(self._z, quantiles, 2)
        z = NormalDist().inv_cdf(1.0 - rate)
        if c < 0.0:
            z = min(z, -0.5 * b / c)  # the parabola's vertex: beyond, it would fall
        return float(max(a + b * z + c * z * z, quantiles[-1]) ** (1.0 / _POWER))

    def _quantiles(
        self, image: Image, most: int, histogram: NDArray[np.int64], shares: tuple[float, ...]
    ) -> tuple[float, ...]:
        stride = max(1, image.size // most) | 1  # odd: else it could fall in step with the rows
        if self._picked.size < -(-image.size // stride):
            self._picked = np.empty(-(-image.size // stride), np.float32)
        count, scale = fill_histogram(image, stride, self._picked, histogram)
        if count == 0:
            return (0.0,) * len(shares)
        return tuple(quantile(histogram, share * count) / scale for share in shares)


@kernel
def fill_histogram(image: Image, stride: int, picked: Row, histogram: NDArray[np.int64]) -> tuple[int, float]:
    """Count every stride-th cell above 0 into a histogram; return how many they are and the bins in a unit.

    (0, 0) when there are none, or when their mean is not finite. picked: work space for the cells.
    """
    cells = image.reshape(image.size)
    total, count = 0.0, 0
    for i in range(0, cells.size, stride):
        picked[count] = cells[i]
        if cells[i] > np.float32(0.0):
            total += cells[i]
            count += 1
    if count == 0 or not np.isfinite(total):
        return 0, 0.0
    scale = np.float32(histogram.size / (_SPAN * (total / count)))
    histogram[:] = 0
    last = np.float32(histogram.size - 1)
    for i in range(count):
        histogram[np.int32(min(last, picked[i] * scale))] += 1
    return count, float(scale)


@kernel
def quantile(histogram: NDArray[np.int64], rank: float) -> float:
    """Return where the running sum of the histogram reaches `rank`, in bins, interpolated."""
    below = 0
    for k in range(histogram.size):
        if below + histogram[k] >= rank:
            return float(k + (rank - below) / max(1, histogram[k]))
        below += histogram[k]
    return float(histogram.size)
