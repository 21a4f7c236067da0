"""Values for missing data, so that no stage has to know of them; and noise of a count."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats32

DRAWN = 16_384
"""Numbers of each kind that are drawn once; every beam of every ping begins at another place among them."""


class FillNoise(NamedTuple):
    """Random numbers."""

    speckle: Floats32
    """Amplitudes of speckle of mean 1."""
    dither: Floats32
    """-1 to 1, of triangular distribution: then neither mean nor variance of the error of counting depend on the signal
    (S. P. Lipshitz, R. A. Wannamaker, J. Vanderkooy, J. Audio Eng. Soc. 40(5), 1992)."""


def draw() -> FillNoise:
    """Return the numbers, always the same ones."""
    rng = np.random.Generator(np.random.SFC64(1))
    speckle = rng.rayleigh(np.sqrt(2.0 / np.pi), DRAWN)
    return FillNoise(speckle.astype(np.float32), (rng.random(DRAWN) - rng.random(DRAWN)).astype(np.float32))
