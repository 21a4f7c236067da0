"""What an image looks like where nothing is: its background level, how much that fluctuates, and how high it peaks."""

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from ods.pipeline.fan import Image
from ods.pipeline.kernel import kernel
from ods.pipeline.mirror import Row

_BINS = 16384
_SPAN = np.float32(8.0)
"""The histogram reaches to this multiple of the mean; all that is higher goes into its last bin."""
_HALVINGS = 12
"""Of the same span, in the search for a quantile: it is then known to 0.1 % of the mean."""
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
        normal = NormalDist()
        self._z = np.array([normal.inv_cdf(share) for share in _TAIL])

    def background_and_noise(self, image: Image) -> tuple[float, float]:
        """Return the median of image (beams, samples) and the distance from there to its 84 % quantile.

        For a normal distribution that distance is the standard deviation; for speckle it takes the long upper tail into
        account. Echoes that fill 1 % of the image raise it by 4 %, 5 % by a fifth. Cells at 0 hold no data and do not
        count; (0, 0) when there are no others, or when the mean is not finite.
        """
        return middle_and_spread(image, *self._room(image, _SAMPLES))

    def level_of_rate(self, image: Image, rate: float) -> float:
        """Return the level that a share `rate` of the cells without echoes exceeds.

        Speckle that was filtered, whatever the sonar and the sample type, is brought close to normal by a power; the
        rest of its shape is taken from three quantiles of the image: x^(1/2) = a + b z + c z^2, z the normal deviate.
        """
        quantiles = np.array(self._quantiles(image)) ** _POWER
        c, b, a = np.polyfit(self._z, quantiles, 2)
        z = NormalDist().inv_cdf(1.0 - rate)
        if c < 0.0:
            z = min(z, -0.5 * b / c)  # the parabola's vertex: beyond, it would fall
        return float(max(a + b * z + c * z * z, quantiles[-1]) ** (1.0 / _POWER))

    def _quantiles(self, image: Image) -> tuple[float, ...]:
        stride, picked = self._room(image, _TAIL_SAMPLES)
        count, scale = fill_histogram(image, stride, picked, self._histogram)
        if count == 0:
            return (0.0,) * len(_TAIL)
        return tuple(quantile(self._histogram, share * count) / scale for share in _TAIL)

    def _room(self, image: Image, most: int) -> tuple[int, Row]:
        """Return the stride at which at most about `most` cells are looked at, and room for them."""
        stride = max(1, image.size // most) | 1  # odd: else it could fall in step with the rows
        count = -(-image.size // stride)
        if self._picked.size < count:
            self._picked = np.empty(count, np.float32)
        return stride, self._picked[:count]


@kernel
def middle_and_spread(image: Image, stride: int, picked: Row) -> tuple[float, float]:
    """Return the median of every stride-th cell above 0 and how far the 84 % quantile is from it.

    (0, 0) when there are none, or when their mean is not finite. picked: room for the cells.
    """
    cells = image.reshape(image.size)
    for i in range(picked.size):
        picked[i] = cells[i * stride]
    total = np.float32(0.0)
    for i in range(picked.size):
        total += picked[i] if picked[i] > np.float32(0.0) else np.float32(0.0)
    count = _number_above(picked, np.float32(0.0))
    if count == np.float32(0.0) or not np.isfinite(total):
        return 0.0, 0.0
    highest = _SPAN * (total / count)
    middle = level_exceeded_by(picked, np.float32(0.5) * count, np.float32(0.0), highest)
    upper = level_exceeded_by(picked, np.float32(1.0 - _UPPER) * count, middle, highest)
    return float(middle), float(upper - middle)


@kernel
def level_exceeded_by(cells: Row, number: np.float32, low: np.float32, high: np.float32) -> np.float32:
    """Return the level between low and high that `number` of the cells exceed, by halving the interval."""
    for _ in range(_HALVINGS):
        middle = np.float32(0.5) * (low + high)
        if _number_above(cells, middle) > number:
            low = middle
        else:
            high = middle
    return np.float32(0.5) * (low + high)


@kernel
def _number_above(cells: Row, level: np.float32) -> np.float32:
    count = np.float32(0.0)  # a float, as counting in integers does not vectorise as well
    for i in range(cells.size):
        count += np.float32(1.0) if cells[i] > level else np.float32(0.0)
    return count


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
