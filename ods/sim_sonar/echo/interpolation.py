"""Tables of a function over [0, 1], looked up by linear interpolation in kernels."""

from ods.base.arrays import Floats
from ods.sim_sonar.kernel import compiled


@compiled
def interpolate(table: Floats, place: float) -> float:
    """Return `table`, even from 0 to 1, at `place`; the ends hold beyond."""
    where = min(max(place, 0.0), 1.0) * (len(table) - 1)
    node = min(int(where), len(table) - 2)
    return float(table[node] + (where - node) * (table[node + 1] - table[node]))
