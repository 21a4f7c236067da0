"""Range ends: a filter sees the image mirrored there. Replicated ends would repeat one speckle sample into an echo."""

import numpy as np
from numpy.typing import NDArray

from ods.pipeline.kernel import kernel

Row = NDArray[np.float32]


@kernel
def mirrored(index: int, samples: int) -> int:
    """Return where a row of `samples` mirrored about its end samples (d c b | a b c d | c b a) has column `index`."""
    if samples == 1:
        return 0
    period = 2 * (samples - 1)
    folded = abs(index) % period
    return folded if folded < samples else period - folded


@kernel
def mirror_row(row: Row, half: int, padded: Row) -> None:
    """Write row (samples,) with `half` mirrored samples at both ends into padded (at least samples + 2 half,)."""
    samples = row.size
    middle = padded[half : half + samples]
    for j in range(samples):
        middle[j] = row[j]
    for i in range(1, half + 1):
        padded[half - i] = row[mirrored(i, samples)]
        padded[half + samples - 1 + i] = row[mirrored(samples - 1 + i, samples)]
