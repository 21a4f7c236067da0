"""Range ends: a filter sees the image mirrored there. Replicated ends would repeat one speckle sample into an echo."""

from ods.base.arrays import Floats32
from ods.compiled.kernel import kernel


@kernel
def mirrored(index: int, samples: int) -> int:
    """Return where a row of `samples` mirrored about its end samples (d c b | a b c d | c b a) has column `index`."""
    if samples == 1:
        return 0
    period = 2 * (samples - 1)
    folded = abs(index) % period
    return folded if folded < samples else period - folded


@kernel
def mirror_ends(padded: Floats32, half: int, samples: int) -> None:
    """Mirror padded[half : half + samples] into the `half` cells before and after it."""
    for i in range(1, half + 1):
        padded[half - i] = padded[half + mirrored(i, samples)]
        padded[half + samples - 1 + i] = padded[half + mirrored(samples - 1 + i, samples)]
