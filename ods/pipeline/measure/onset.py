"""How sharply an echo sets in: a body's face is met at once, what shines of a rough bottom grows and fades."""

import numpy as np

from ods.base.arrays import Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.regions import Runs


@kernel
def onset_of(image: Image, runs: Runs, point: float) -> float:
    """Return how far the echo's highest level lies behind the place before it that has half of that, in its beam.

    In units of `point`, the width of a point, columns (0: not known), whatever the levels of detection. Returns 0 where
    that is not known, or the image or its data begin later.
    """
    beam, peak = _peak(image, runs)
    row = image[beam]
    half = np.float32(0.5) * row[peak]
    last = peak
    while last > 0 and row[last - 1] >= half:
        last -= 1
    if point <= 0.0 or last == 0 or row[last - 1] <= 0.0:
        return 0.0
    part = (row[last] - half) / (row[last] - row[last - 1])
    return float((peak - last + part) / point)


@kernel
def _peak(image: Image, runs: Runs) -> tuple[int, int]:
    """Return beam and column of the highest level in these runs."""
    beam, peak = runs[0].beam, runs[0].first
    for i in range(runs.shape[0]):
        for j in range(runs[i].first, runs[i].stop):
            if image[runs[i].beam, j] > image[beam, peak]:
                beam, peak = runs[i].beam, j
    return beam, peak
