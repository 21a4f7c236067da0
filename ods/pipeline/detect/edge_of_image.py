"""Echoes at the image's border, where filters see less: they have to be stronger to count.

A filter mirrors the image there, so half of its samples count twice, and its noise has up to twice the power that it
has elsewhere; the equalizers, too, know only one side.
"""

import numpy as np

from ods.base.arrays import Image, Mask
from ods.compiled import native
from ods.pipeline.detect.rise import Rise
from ods.pipeline.image.regions import Regions


def strong_at_border(image: Image, regions: Regions, high: float, raised: float, rise: Rise) -> Mask:
    """Return (total,) bool: regions that have a cell above `high` that is not in the border, or one above `raised`.

    image: (beams, samples). Both levels rise as the low one does.
    """
    strong = np.empty(regions.total, np.bool_)
    native.strong_at_border(image, regions.runs, high, raised, rise, strong)
    return strong
