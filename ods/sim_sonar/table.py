"""Tables of a function over [0, 1], looked up by linear interpolation in kernels."""

import numpy as np
from numpy.typing import NDArray

from ods.sim_sonar.jit import compiled

Array = NDArray[np.float64]


@compiled
def look_up(table: Array, place: float) -> float:
    """Return `table`, even from 0 to 1, at `place`; the ends hold beyond."""
    where = min(max(place, 0.0), 1.0) * (len(table) - 1)
    node = min(int(where), len(table) - 2)
    return float(table[node] + (where - node) * (table[node + 1] - table[node]))
