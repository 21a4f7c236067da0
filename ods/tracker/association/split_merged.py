"""Where echoes and objects are not one to one: several echoes of a large object, one echo of two close objects."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled import native
from ods.tracker.association.gating import Hypotheses
from ods.tracker.measurement.model import PredictedMeasurement
from ods.tracker.measurement.scan import Echoes
from ods.tracker.named import Named
from ods.tracker.observer.belief import Estimate

PART_SHARE = 0.5
"""The middle of the parts of a large object that are seen lies off its centre by about this share of its radius."""


class Parts(NamedTuple):
    """Objects of which only parts were seen: (k,) each."""

    objects: Indices
    """Each once."""
    llr: Floats
    """See `Hypotheses`; of the strongest of its echoes."""
    echoes: Echoes
    """The middle of all its echoes."""
    variance: Floats
    """Of the distance between that middle and the object's centre, m^2."""


def parts_inside(
    predicted: Named[PredictedMeasurement], radius: Floats, echoes: Echoes, objects: Indices, loose: Indices
) -> tuple[Indices, Indices]:
    """Find the `loose` echoes that are inside the circle of one of `objects`.

    `predicted`: (n,) arrays; `radius`: (n,). Returns pairs of the object, that whose circle the echo is deepest in, and
    the echo; an object may come more than once.
    """
    wholes, parts = np.empty((2, len(loose)), np.intp)
    found = native.parts_inside(predicted.table, radius, echoes.table, objects, loose, wholes, parts)
    return wholes[:found], parts[:found]


def put_together(pairs: Hypotheses, echoes: Echoes, radius: Floats) -> Parts:
    """Put the echoes of each object of `pairs` together; `radius`: of all objects."""
    most, rows = len(pairs.objects), len(echoes.table)
    objects, llr, middles = np.empty(most, np.intp), np.empty(most), np.empty((rows, most))
    k = native.put_together(pairs, echoes.table, len(radius), objects, llr, middles)
    objects, middle = objects[:k], Echoes(middles.ravel()[: rows * k].reshape(rows, k))
    return Parts(objects, llr[:k], middle, (PART_SHARE * radius[objects]) ** 2)


def merged_variance(estimate: Estimate, hit: Mask, reported: Mask, watched: Floats) -> Floats:
    """Return (n,) variance, m^2, by which an echo may lie off its object's centre because it is of two objects.

    Where the circles of two objects touch and only one of them is `hit`, its echo may be the echo of both; both are
    confirmed, `reported`, and the sonar looks at them with a probability `watched`, all (n,). 0: no such neighbour.
    """
    variance = np.empty(len(estimate.radius))
    native.merged_variance(estimate.position, estimate.radius, hit, reported, watched, variance)
    return variance
