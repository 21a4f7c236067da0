"""Speckle: the noise that a mean intensity image becomes when the echoes of many scatterers add up by chance."""

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainccinv, gammaincinv, ndtr

from ods.sim_sonar.jit import compiled

Array = NDArray[np.float64]
Image = NDArray[np.float32]

TABLE_REACH = 6.0
"""Standard deviations of the normal variable that the table covers; one sample in 5e8 lies beyond."""
TABLE_NODES = 4097


def amplitude_table(looks: float) -> Image:
    """Return sqrt(g) for normal quantiles even in +-TABLE_REACH, where g is Gamma distributed: mean 1, shape `looks`.

    Turning normal noise into Gamma noise quantile by quantile gives any real number of looks, and keeps whatever
    correlation the normal noise has. looks = 1 is fully developed speckle: Rayleigh amplitude, exponential intensity.
    """
    normal = np.linspace(-TABLE_REACH, TABLE_REACH, TABLE_NODES)
    lower, upper = gammaincinv(looks, ndtr(normal)), gammainccinv(looks, ndtr(-normal))
    return np.sqrt(np.where(normal < 0.0, lower, upper) / looks).astype(np.float32)


@compiled
def speckled(intensity: Array, normal: Image, table: Image, floor: float, out: Image) -> None:
    """Set `out` to the amplitude sqrt(intensity + floor) times the speckle of `normal`; all (beams, samples)."""
    scale = np.float32((TABLE_NODES - 1) / (2.0 * TABLE_REACH))
    middle = np.float32(0.5 * (TABLE_NODES - 1))
    last = np.float32(TABLE_NODES - 1.001)
    for beam in range(len(out)):
        row, noise, level = out[beam], normal[beam], intensity[beam]
        for j in range(len(row)):
            place = min(max(noise[j] * scale + middle, np.float32(0.0)), last)
            node = int(place)
            share = place - np.float32(node)
            factor = table[node] + share * (table[node + 1] - table[node])
            row[j] = np.float32(np.sqrt(level[j] + floor)) * factor
