"""Range of clear water by direction: the nearest echo of the pixels around it."""

import numpy as np

from ods.base.arrays import Mask
from ods.messages import LookedVolume
from ods.pipeline.range_image.points import RangePixels

BEARINGS, ELEVATIONS = 64, 16
"""Most cells; fewer where there are fewer pixels."""


def looked_of(pixels: RangePixels, believed: Mask, range_max_m: float) -> LookedVolume:
    """Return the range up to which nothing was received, in cells of directions.

    believed: (bearings, elevations) pixels whose echo counts, those of the bottom too.
    """
    clear = np.where(believed, pixels.range_m, np.float32(range_max_m))
    for axis, most in enumerate((BEARINGS, ELEVATIONS)):
        count = clear.shape[axis]
        cells = min(most, count)
        firsts = np.arange(cells) * count // cells
        clear = np.minimum.reduceat(clear, firsts, axis)
    elevation = pixels.elevation_rad
    return LookedVolume(
        bearings=clear.shape[0],
        elevations=clear.shape[1],
        elevation_min_rad=float(elevation[0]),
        elevation_max_rad=float(elevation[-1]),
        clear_m=clear.astype("<f4").tobytes(),
    )
