"""Which echo belongs to which object, in probability: an object is corrected by all echoes that may be its own.

Joint probabilistic data association, with the marginal probabilities by belief propagation: J. L. Williams and
R. A. Lau, Approximate evaluation of marginal association probabilities with belief propagation, IEEE Trans. AES 50(4),
2014. They are exact where the pairs make no loops. The echoes of an object are then put together to one at their
middle, whose noise is such that the ordinary update ends in the variance of probabilistic data association:
Y. Bar-Shalom, F. Daum, J. Huang, The probabilistic data association filter, IEEE Control Systems 29(6), 2009.
"""

import math

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.base.kernel import kernel
from ods.tracker.association.gnn import Candidates, Pairing, associate
from ods.tracker.measurement.model import Sight, wrapped
from ods.tracker.measurement.scan import BEARING, RADIUS, RANGE, SIGMA_RANGE, Echoes
from ods.tracker.observer.belief import Estimate

MOST_WORTH = 25.0
"""Largest log-likelihood ratio of a pair: e^25 leaves no doubt, and no rival's share is lost to rounding."""
ROUNDS = 20
"""Most rounds of messages,"""
SETTLED = 1e-3
"""and the largest change of a message, all between 0 and 1, with which they end."""
SEEN = 0.5
"""An object is seen, and an echo starts no new object, when it is more probable than this that the other is there."""
MEASURED = (RANGE, BEARING, RADIUS)
"""Rows of echoes; their standard deviations are three rows from SIGMA_RANGE on."""
LEAST_GAIN = 0.05
"""Where echoes far apart would make an object's variance grow, its gain is this share of that of a sure echo."""


def probabilistic(
    found: Candidates, worth: Floats, first: Mask, echoes: Echoes, sight: Sight, estimate: Estimate
) -> Pairing:
    """See `ods.tracker.association.registry.Association`.

    Only the objects of the mask `first` share echoes. The others are mostly rivals for being the same object: they
    take one echo each, from what is left.
    """
    senior = first[found.objects]
    shared = found.take(senior)
    share, free = shares(shared, worth[senior], len(first), len(echoes))
    explained = np.bincount(shared.echoes, share, len(echoes)) > SEEN
    best, evidence, table = _put_together(shared, share, free, echoes.table, sight, estimate)
    left = ~senior & ~explained[found.echoes]
    others = associate(found.take(left), worth[left], first, len(echoes))
    explained[others.echoes] = True
    pairs = Candidates(shared.objects[best], shared.echoes[best], evidence).joined(others)
    return Pairing(pairs, Echoes(table).joined(echoes.take(others.echoes)), explained)


@kernel
def shares(found: Candidates, worth: Floats, objects: int, echoes: int) -> tuple[Floats, Floats]:
    """Return (p,) the probability of each pair, and (p,) that its echo is of no other object.

    Messages: of an object to an echo, the odds that it takes it; of an echo to an object, that no other takes it.
    """
    ratio = np.exp(np.minimum(worth, MOST_WORTH))
    free, odds = np.ones(len(worth)), np.empty(len(worth))
    change, rounds = 1.0, 0
    while change > SETTLED and rounds < ROUNDS:
        change, rounds = 0.0, rounds + 1
        of_object, of_echo = np.ones(objects), np.ones(echoes)
        for k in range(len(worth)):
            of_object[found.objects[k]] += ratio[k] * free[k]
        for k in range(len(worth)):
            odds[k] = ratio[k] / max(of_object[found.objects[k]] - ratio[k] * free[k], 1.0)
            of_echo[found.echoes[k]] += odds[k]
        for k in range(len(worth)):
            before, free[k] = free[k], 1.0 / max(of_echo[found.echoes[k]] - odds[k], 1.0)
            change = max(change, abs(free[k] - before))
    of_object = np.ones(objects)
    for k in range(len(worth)):
        of_object[found.objects[k]] += ratio[k] * free[k]
    share = np.empty(len(worth))
    for k in range(len(worth)):
        share[k] = ratio[k] * free[k] / of_object[found.objects[k]]
    return share, free


@kernel
def _put_together(
    found: Candidates, share: Floats, free: Floats, echoes: Floats, sight: Sight, estimate: Estimate
) -> tuple[Indices, Floats, Floats]:
    """Return, of the k objects seen, the most probable pair (k,), the evidence (k,) and one echo (7, k) each.

    `free`: (p,) probability that a pair's echo is not of another object.
    """
    n = len(estimate.radius)
    strongest, seen, chance = np.full(n, -1), np.zeros(n), np.zeros(n)
    moments = np.zeros((3, 3, n))
    for k in range(len(share)):
        i, j = found.objects[k], found.echoes[k]
        if strongest[i] < 0 or share[k] > share[strongest[i]]:
            strongest[i] = k
        seen[i] += share[k]
        chance[i] += free[k] * math.exp(min(found.evidence[k], MOST_WORTH))
        innovation = (
            echoes[RANGE, j] - sight.range_m[i],
            wrapped(echoes[BEARING, j] - sight.bearing[i]),
            echoes[RADIUS, j] - estimate.radius[i],
        )
        for axis in range(3):
            moments[axis, 0, i] += share[k] * innovation[axis]
            moments[axis, 1, i] += share[k] * innovation[axis] ** 2
            moments[axis, 2, i] += share[k] * echoes[SIGMA_RANGE + axis, j] ** 2
    objects = (seen > SEEN).nonzero()[0]
    best, evidence, table = strongest[objects], np.log(chance[objects]), np.empty((echoes.shape[0], len(objects)))
    for k in range(len(objects)):
        i = objects[k]
        table[:, k] = echoes[:, found.echoes[best[k]]]
        predicted = sight.range_m[i], sight.bearing[i], estimate.radius[i]
        variance = sight.along[i], sight.across[i] / sight.horizontal[i] ** 2, estimate.radius_variance[i]
        for axis in range(3):
            mean, square, noise = moments[axis, 0, i], moments[axis, 1, i], moments[axis, 2, i] / seen[i]
            table[MEASURED[axis], k] = predicted[axis] + mean / seen[i]
            table[SIGMA_RANGE + axis, k] = math.sqrt(noise_together(seen[i], mean, square, variance[axis], noise))
    return best, evidence, table


@kernel
def noise_together(seen: float, mean: float, square: float, variance: float, noise: float) -> float:
    """Return the noise variance of the middle of several measurements with which an update ends where all of them do.

    `seen`: sum of the probabilities of the measurements; `mean`, `square`: sums of their innovations and of the squares
    by these weights; `variance`: of the prediction; `noise`: of a measurement. With S = variance + noise, probabilistic
    data association takes (variance / S)^2 (seen S - square + mean^2) off the variance; so does an update with the
    noise returned. Its step is that of probabilistic data association, too, but smaller where innovations are spread:
    no single measurement at the middle gives both.
    """
    total = variance + noise
    lowered = max(seen * total - max(square - mean**2, 0.0), LEAST_GAIN * total)
    return noise + total * (total / lowered - 1.0)
