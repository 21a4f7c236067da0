"""Echoes that the fan's edge cuts off: what they tell of an object that is known already."""

import math

from ods.base.arrays import Floats
from ods.compiled import native
from ods.compiled.kernel import kernel
from ods.tracker.measurement.scan import Echoes


def nothing_twice(echoes: Echoes, predicted: Floats, radius: Floats, radius_variance: Floats) -> Echoes:
    """Return k echoes, those cut off with noise by which none betters what is known beyond its own error.

    `predicted`: (8, k), the table of `PredictedMeasurement`, of the objects that the echoes are of; radius, m, and its
    variance: (k,), as they are known. What is seen of a body lies inside its circle: so far at most off its middle.
    """
    table = echoes.table.copy()
    native.nothing_twice(table, predicted, radius, radius_variance)
    return Echoes(table)


@kernel
def farthest_off(cut: float, radius: float, radius_variance: float) -> float:
    """Return the largest variance, m^2, that the place of an echo of an object of this radius can have.

    What is seen of a body lies inside its circle: so far at most off its middle. Of an echo that is not `cut` this says
    nothing.
    """
    return radius**2 + radius_variance if cut else math.inf
