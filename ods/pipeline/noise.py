"""What an image looks like where nothing is: its background level and how much that fluctuates."""

import numpy as np
from numpy.typing import NDArray

from ods.pipeline.fan import Image
from ods.pipeline.kernel import kernel

_BINS = 1024
_SPAN = np.float32(8.0)
"""The histogram reaches to this multiple of the mean; all that is higher goes into its last bin."""
_SAMPLES = 4096
"""Cells looked at: the spread of Rayleigh speckle is then known to about 3 %."""
_UPPER = 0.8413
"""Quantile one standard deviation above the middle of a normal distribution."""


def new_histogram() -> NDArray[np.int64]:
    """Return the work space of `background_and_noise`."""
    return np.empty(_BINS, np.int64)


@kernel
def background_and_noise(image: Image, histogram: NDArray[np.int64]) -> tuple[float, float]:
    """Return the median of image (beams, samples) and the distance from there to its 84 % quantile.

    For a normal distribution that distance is the standard deviation; for speckle it takes the long upper tail into
    account. Echoes that fill 1 % of the image raise it by 4 %, 5 % by a fifth. Cells at 0 hold no data and do not
    count; (0, 0) when there are no others, or when the mean is not finite.
    """
    cells = image.reshape(image.size)
    stride = max(1, cells.size // _SAMPLES) | 1  # odd: else it could fall in step with the rows
    total, count = 0.0, 0
    for i in range(0, cells.size, stride):
        if cells[i] > np.float32(0.0):
            total += cells[i]
            count += 1
    if count == 0 or not np.isfinite(total):
        return 0.0, 0.0
    scale = np.float32(_BINS / (_SPAN * (total / count)))
    histogram[:] = 0
    for i in range(0, cells.size, stride):
        if cells[i] > np.float32(0.0):
            histogram[min(_BINS - 1, int(cells[i] * scale))] += 1
    middle = _quantile(histogram, 0.5 * count) / scale
    upper = _quantile(histogram, _UPPER * count) / scale
    return float(middle), float(upper - middle)


@kernel
def _quantile(histogram: NDArray[np.int64], rank: float) -> float:
    """Return where the running sum of the histogram reaches `rank`, in bins, interpolated."""
    below = 0
    for k in range(histogram.size):
        if below + histogram[k] >= rank:
            return float(k + (rank - below) / max(1, histogram[k]))
        below += histogram[k]
    return float(histogram.size)
