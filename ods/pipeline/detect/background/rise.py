"""Levels that rise where the crests of the background are higher than those of speckle."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Image


class ThresholdRise(NamedTuple):
    """Rise of the levels: their part above the background is multiplied by a power of a factor that depends on the
    position."""

    background: float
    factors: Floats
    """(rows, columns) of each place, 1 or more."""
    low_power: float
    """Power for the low level,"""
    high_power: float
    """and for the high one."""
    beams: int
    """Of a place,"""
    samples: int
    """likewise; the last row and column of places reach to the image's border."""

    @classmethod
    def none(cls) -> "ThresholdRise":
        """Return one that leaves all levels as they are."""
        return cls(0.0, np.empty((0, 0)), 0.0, 0.0, 1, 1)


def levelled(image: Image, rise: ThresholdRise) -> Image:
    """Return image (beams, samples) with what is over the background divided as the low level rises.

    The same array is returned where it rises nowhere.
    """
    divisors = rise.factors**rise.low_power
    if (divisors == 1.0).all():
        return image
    rows, columns = (
        np.minimum(np.arange(cells) // size, places - 1)
        for cells, size, places in zip(image.shape, (rise.beams, rise.samples), divisors.shape, strict=True)
    )
    divisor = divisors[np.ix_(rows, columns)]
    lowered = rise.background + (image - rise.background) / divisor
    return np.asarray(np.where(divisor == 1.0, image, lowered), np.float32)
