"""Bodies in a range image: connected pixels of like ranges, as in range images of lidars.

I. Bogoslavskyi and C. Stachniss, IROS 2016: two pixels are of one surface unless it would lie nearly along the line of
sight, and neighbours further away are looked at as images have gaps.
"""

import math

import numpy as np

from ods.base.arrays import Indices, Mask
from ods.compiled import native
from ods.pipeline.range_image.points import RangePixels

GRAZING = math.radians(10.0)
"""Least angle of a surface to the line of sight for its points to be joined, rad."""


def bodies_of(pixels: RangePixels, wanted: Mask, noise_m: float, fewest: int) -> list[Indices]:
    """Return the places of each body's pixels in the flat image; bodies that have too few are left out."""
    numbers = np.empty(wanted.shape, np.int32)
    native.cluster_ranges(pixels.range_m, wanted, *pixels.spacing_rad, noise_m, 1.0 / math.tan(GRAZING), numbers)
    flat = numbers.ravel()
    places = np.flatnonzero(flat)
    order = places[np.argsort(flat[places], kind="stable")]
    borders = np.flatnonzero(np.diff(flat[order])) + 1
    return [part for part in np.split(order, borders) if part.size >= fewest]
