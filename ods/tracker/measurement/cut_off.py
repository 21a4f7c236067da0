"""Echoes that the fan's edge cuts off: what they tell of an object that is known already.

Of a body that reaches beyond the fan only a part is seen. Where in the body it lies nobody knows, and as the fan passes
over the body its middle slides along it: an error that stays, or looks like a motion, and that no number of pings
averages away.
"""

import math

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel
from ods.tracker.measurement.model import predicted_rows
from ods.tracker.measurement.scan import Echoes, echo_rows

NOTHING = 1e8
"""Variance of what a measurement does not tell, m^2."""


def nothing_twice(echoes: Echoes, predicted: Floats, radius: Floats, radius_variance: Floats) -> Echoes:
    """Return k echoes, those cut off with noise by which none betters what is known beyond its own error.

    `predicted`: (8, k), the table of `PredictedMeasurement`, of the objects that the echoes are of; radius, m, and its
    variance: (k,), as they are known. What is seen of a body lies inside its circle: so far at most off its middle.
    """
    return Echoes(_nothing_twice(echoes.table, predicted, radius, radius_variance))


@kernel
def farthest_off(cut: float, radius: float, radius_variance: float) -> float:
    """Return the largest variance, m^2, that the place of an echo of an object of this radius can have.

    What is seen of a body lies inside its circle: so far at most off its middle. Of an echo that is not `cut` this says
    nothing.
    """
    return radius**2 + radius_variance if cut else math.inf


@kernel
def _nothing_twice(table: Floats, predicted_table: Floats, radius: Floats, radius_variance: Floats) -> Floats:
    result, predicted = table.copy(), predicted_rows(predicted_table)
    echoes = echo_rows(result)
    for j in range(table.shape[1]):
        if echoes.cut[j] == 0.0:
            continue
        largest = max(radius[j], echoes.radius[j])
        most, horizontal = farthest_off(echoes.cut[j], largest, radius_variance[j]), predicted.horizontal[j]
        along = min(echoes.sigma_range[j] ** 2, most)
        across = min((echoes.sigma_bearing[j] * horizontal) ** 2, most)
        echoes.sigma_range[j] = math.sqrt(_beyond(along, predicted.along[j]))
        echoes.sigma_bearing[j] = math.sqrt(_beyond(across, predicted.across[j])) / horizontal
        shared, known = echoes.sigma_radius[j] ** 2, radius_variance[j]
        noise = _beyond(shared, known)
        echoes.sigma_radius[j] = math.sqrt(noise)
        larger = max(echoes.radius[j] - radius[j], 0.0)  # what is seen of a body is never larger than the body
        if noise == NOTHING and larger > 0.0:  # so far as an echo on its own would, but it does not make it surer
            echoes.radius[j] = radius[j] + larger * (known + noise) / (known + shared)
    return result


@kernel
def _beyond(shared: float, known: float) -> float:
    """Return the variance of independent noise after which as much is left of `known` as of the error `shared`."""
    return known * shared / (known - shared) if known > (1.0 + 1e-6) * shared else NOTHING
