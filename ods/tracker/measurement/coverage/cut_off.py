"""Echoes cut off by the fan's edge: the information they give about a known object."""

from ods.base.arrays import Floats
from ods.compiled import native
from ods.tracker.measurement.scan import Echoes

NOT_MEASURED = 1e8
"""Variance of what was not measured, m^2."""


def limit_information(echoes: Echoes, predicted: Floats, radius: Floats, radius_variance: Floats) -> Echoes:
    """Return k echoes, those cut off with noise by which none betters what is known beyond its own error.

    `predicted`: (8, k), the table of `PredictedMeasurement`, of the objects that the echoes are of; radius, m, and its
    variance: (k,), as they are known. The visible part of an object lies inside its circle: at most this far from its
    middle.
    """
    table = echoes.table.copy()
    native.limit_information(table, predicted, radius, radius_variance, NOT_MEASURED)
    return Echoes(table)
