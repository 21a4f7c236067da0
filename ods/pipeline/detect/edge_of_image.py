"""Echoes at the image's border, where filters see less: they have to be stronger to count.

A filter mirrors the image there, so half of its samples count twice, and its noise has up to twice the power that it
has elsewhere; the equalizers, too, know only one side.
"""

import numpy as np

from ods.base.arrays import Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.regions import Runs, chosen_runs

_BEAMS, _SAMPLES = 2, 4
"""Width of the border, cells: that of the default filter's half window."""
_LEAST_BEAMS, _LEAST_SAMPLES = 16, 64
"""An image of fewer has no such border: it would be all border."""


@kernel
def without_weak_at_border(
    image: Image, runs: Runs, total: int, high: np.float32, raised: np.float32
) -> tuple[Runs, int]:
    """Return the regions without those whose cells above `high` all lie in the border, and none above `raised`.

    They are numbered anew. image: (beams, samples).
    """
    beams = _BEAMS if image.shape[0] >= _LEAST_BEAMS else 0
    samples = _SAMPLES if image.shape[1] >= _LEAST_SAMPLES else 0
    kept = np.zeros(total, np.bool_)
    for i in range(runs.shape[0]):
        run = runs[i]
        outer = run.beam < beams or run.beam >= image.shape[0] - beams
        for j in range(run.first, run.stop):
            ends = j < samples or j >= image.shape[1] - samples
            if image[run.beam, j] > (raised if outer or ends else high):
                kept[run.region - 1] = True
                break
    return chosen_runs(runs, kept)
