"""Where echoes and objects are not one to one: several echoes of a large object, one echo of two close objects."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled.kernel import kernel
from ods.tracker.association.gating import Hypotheses
from ods.tracker.measurement.model import PredictedMeasurement, predicted_rows, wrapped
from ods.tracker.measurement.scan import Echoes, echo_rows
from ods.tracker.named import Named
from ods.tracker.observer.belief import Estimate

PART_SHARE = 0.5
"""The middle of the parts of a large object that are seen lies off its centre by about this share of its radius."""
SMALLEST_OFFSET_M = 1e-3
"""The echo of two objects at one place is off the centre of each by at least this."""


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
    return _parts_inside(predicted.table, radius, echoes.table, objects, loose)


@kernel
def _parts_inside(
    predicted_table: Floats, radius: Floats, echo_table: Floats, objects: Indices, loose: Indices
) -> tuple[Indices, Indices]:
    predicted, echoes = predicted_rows(predicted_table), echo_rows(echo_table)
    wholes, parts, found = np.empty(len(loose), np.intp), np.empty(len(loose), np.intp), 0
    for j in loose:
        deepest, whole = 0.0, -1
        for i in objects:
            along = echoes.range_m[j] - predicted.range_m[i]
            if abs(along) < radius[i]:
                across = wrapped(echoes.bearing[j] - predicted.bearing[i]) * predicted.horizontal[i]
                excess = math.hypot(along, across) - radius[i]
                if excess < deepest:
                    deepest, whole = excess, i
        if whole >= 0:
            wholes[found], parts[found] = whole, j
            found += 1
    return wholes[:found], parts[:found]


def put_together(pairs: Hypotheses, echoes: Echoes, radius: Floats) -> Parts:
    """Put the echoes of each object of `pairs` together; `radius`: of all objects."""
    objects, llr, middle = _put_together(pairs, echoes.table, len(radius))
    return Parts(objects, llr, Echoes(middle), (PART_SHARE * radius[objects]) ** 2)


@kernel
def _put_together(pairs: Hypotheses, table: Floats, all_objects: int) -> tuple[Indices, Floats, Floats]:
    """Return objects (k,), their best log-likelihood ratios (k,) and middle echoes (12, k), of the (12, m) `table`."""
    place, k = np.full(all_objects, -1), 0
    count = np.zeros(len(pairs.objects))
    wholes, llr = np.empty(len(count), np.intp), np.empty(len(count))
    middles = np.empty((len(table), len(count)))
    middle, echoes = echo_rows(middles), echo_rows(table)
    for pair, i in enumerate(pairs.objects):
        j = pairs.echoes[pair]
        if place[i] < 0:
            place[i], wholes[k], llr[k] = k, i, pairs.llr[pair]
            middles[:, k] = table[:, j]
            k += 1
        else:
            llr[place[i]] = max(llr[place[i]], pairs.llr[pair])
            middle.range_m[place[i]] += echoes.range_m[j]
            middle.bearing[place[i]] += echoes.bearing[j]
        count[place[i]] += 1.0
    middle.range_m[:] /= count
    middle.bearing[:] /= count
    return wholes[:k], llr[:k], middles[:, :k].copy()


def merged_variance(estimate: Estimate, hit: Mask, reported: Mask, watched: Floats) -> Floats:
    """Return (n,) variance, m^2, by which an echo may lie off its object's centre because it is of two objects.

    Where the circles of two objects touch and only one of them is `hit`, its echo may be the echo of both; both are
    confirmed, `reported`, and the sonar looks at them with a probability `watched`, all (n,). 0: no such neighbour.
    """
    return _merged(estimate.position, estimate.radius, hit, reported, watched)


@kernel
def _merged(position: Floats, radius: Floats, hit: Mask, reported: Mask, watched: Floats) -> Floats:
    result, here = np.zeros(len(radius)), reported & (watched > 0.0)
    unseen = (here & ~hit).nonzero()[0]
    for i in range(len(radius)):
        if not (here[i] and hit[i]):
            continue
        for j in unseen:
            north = position[0, i] - position[0, j]
            reach = radius[i] + radius[j]
            if abs(north) < reach:
                separation = math.hypot(north, position[1, i] - position[1, j])
                if separation < reach:
                    half = max(0.5 * separation, SMALLEST_OFFSET_M) ** 2
                    result[i], result[j] = max(result[i], half), max(result[j], half)
    return result
