"""Which echo belongs to which object, in probability: an object is corrected by all echoes that may be its own.

Joint probabilistic data association, with the marginal probabilities by belief propagation: J. L. Williams and
R. A. Lau, Approximate evaluation of marginal association probabilities with belief propagation, IEEE Trans. AES 50(4),
2014. They are exact where the pairs make no loops. The echoes of an object are then put together to one at their
middle, whose noise is such that the ordinary update ends in the variance of probabilistic data association:
Y. Bar-Shalom, F. Daum, J. Huang, The probabilistic data association filter, IEEE Control Systems 29(6), 2009.
"""

import math

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.compiled.kernel import kernel
from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.gating import Hypotheses
from ods.tracker.association.gnn import best_pairs
from ods.tracker.measurement.model import PredictedMeasurement, predicted_rows, wrapped
from ods.tracker.measurement.scan import Echoes, EchoRows, echo_rows

MOST_RATIO = 25.0
"""Largest log-likelihood ratio of a pair: e^25 leaves no doubt, and no rival's share is lost to rounding."""
ROUNDS = 20
"""Most rounds of messages,"""
CONVERGED = 1e-3
"""and the largest change of a message, all between 0 and 1, with which they end."""
MORE_LIKELY = 0.5
"""An object is seen, and an echo starts no new object, when it is more probable than this that the other is there."""
RIVAL = 0.1
"""An echo with less than this share of the probability of an object's most probable one is no rival of it."""
LEAST_GAIN = 0.05
"""Where echoes far apart would make an object's variance grow, its gain is this share of that of a sure echo."""


def probabilistic(question: Question) -> Assignment:
    """See `ods.tracker.association.registry.Association`.

    Only the objects that choose first share echoes. The others are mostly rivals for being the same object: they take
    one echo each, from what is left.
    """
    hypotheses, first, echoes, predicted, estimate = question
    senior = first[hypotheses.objects]
    shared = hypotheses.take(senior)
    share, free = shares(shared, len(first), len(echoes))
    explained = np.bincount(shared.echoes, share, len(echoes)) > MORE_LIKELY
    radius = estimate.radius, estimate.radius_variance
    best, llr, together = _put_together(shared, (share, free), echoes.table, predicted.table, radius)
    others = best_pairs(hypotheses.take(~senior & ~explained[hypotheses.echoes]), first, len(echoes))
    explained[others.echoes] = True
    pairs = Hypotheses(shared.objects[best], shared.echoes[best], llr, shared.score[best]).joined(others)
    return Assignment(pairs, Echoes(together).joined(echoes.take(others.echoes)), explained)


@kernel
def shares(hypotheses: Hypotheses, objects: int, echoes: int) -> tuple[Floats, Floats]:
    """Return (p,) the probability of each pair, and (p,) that its echo is of no other object.

    Messages: of an object to an echo, the odds that it takes it; of an echo to an object, that no other takes it.
    """
    ratio = np.exp(np.minimum(hypotheses.score, MOST_RATIO))
    free, odds = np.ones(len(ratio)), np.empty(len(ratio))
    change, rounds = 1.0, 0
    while change > CONVERGED and rounds < ROUNDS:
        change, rounds = 0.0, rounds + 1
        of_object, of_echo = np.ones(objects), np.ones(echoes)
        for k in range(len(ratio)):
            of_object[hypotheses.objects[k]] += ratio[k] * free[k]
        for k in range(len(ratio)):
            odds[k] = ratio[k] / max(of_object[hypotheses.objects[k]] - ratio[k] * free[k], 1.0)
            of_echo[hypotheses.echoes[k]] += odds[k]
        for k in range(len(ratio)):
            before, free[k] = free[k], 1.0 / max(of_echo[hypotheses.echoes[k]] - odds[k], 1.0)
            change = max(change, abs(free[k] - before))
    of_object = np.ones(objects)
    for k in range(len(ratio)):
        of_object[hypotheses.objects[k]] += ratio[k] * free[k]
    share = np.empty(len(ratio))
    for k in range(len(ratio)):
        share[k] = ratio[k] * free[k] / of_object[hypotheses.objects[k]]
    return share, free


@kernel
def _put_together(
    hypotheses: Hypotheses,
    probabilities: tuple[Floats, Floats],
    echo_table: Floats,
    predicted_table: Floats,
    radii: tuple[Floats, Floats],
) -> tuple[Indices, Floats, Floats]:
    """Return, of k objects seen, the most probable pair and its log-likelihood ratio (k,) and one echo (12, k) each.

    `probabilities`: those of `shares`; `radii`: (n,) radius as predicted, and its variance.
    """
    radius, radius_variance = radii
    echoes, predicted = echo_rows(echo_table), predicted_rows(predicted_table)
    strongest, seen, chance, mean, square, noise = _added_up(hypotheses, probabilities, echoes, predicted, radius)
    objects = (seen > MORE_LIKELY).nonzero()[0]
    best, llr, count = strongest[objects], np.log(chance[objects]), len(objects)
    table = np.empty((len(echo_table), count))
    made = echo_rows(table)
    measured = made.range_m, made.bearing, made.radius
    sigmas = made.sigma_range, made.sigma_bearing, made.sigma_radius
    _tell_what_holds_for_any(made, hypotheses, (probabilities[0], strongest, objects), echoes)
    for k in range(count):
        i = objects[k]
        j = hypotheses.echoes[best[k]]
        made.strength[k], made.onset[k], made.front[k] = echoes.strength[j], echoes.onset[j], echoes.front[j]
        middle = predicted.range_m[i], predicted.bearing[i], radius[i]
        variance = (
            predicted.along[i],
            predicted.across[i] / predicted.horizontal[i] ** 2,
            radius_variance[i],
        )
        for axis in range(3):
            own = noise[axis, i] / seen[i]
            together = noise_together(seen[i], mean[axis, i], square[axis, i], variance[axis], own)
            measured[axis][k] = middle[axis] + mean[axis, i] / seen[i]
            sigmas[axis][k] = math.sqrt(together)
    return best, llr, table


@kernel
def _added_up(
    hypotheses: Hypotheses,
    probabilities: tuple[Floats, Floats],
    echoes: EchoRows,
    predicted: PredictedMeasurement,
    radius: Floats,
) -> tuple[Indices, Floats, Floats, Floats, Floats, Floats]:
    """Return, of n objects, the strongest pair (n,) and sums over the pairs of each object.

    These are the probabilities and the likelihood ratios (n,), and (3, n) by probability the innovations of range,
    bearing and radius, their squares, and the variances of the noise.
    """
    share, free = probabilities
    n = len(radius)
    strongest, seen, chance = np.full(n, -1), np.zeros(n), np.zeros(n)
    mean, square, noise = np.zeros((3, n)), np.zeros((3, n)), np.zeros((3, n))
    for k in range(len(share)):
        i, j = hypotheses.objects[k], hypotheses.echoes[k]
        if strongest[i] < 0 or share[k] > share[strongest[i]]:
            strongest[i] = k
        seen[i] += share[k]
        chance[i] += free[k] * math.exp(min(hypotheses.llr[k], MOST_RATIO))
        innovation = (
            echoes.range_m[j] - predicted.range_m[i],
            wrapped(echoes.bearing[j] - predicted.bearing[i]),
            echoes.radius[j] - radius[i],
        )
        sigma = echoes.sigma_range[j], echoes.sigma_bearing[j], echoes.sigma_radius[j]
        for axis in range(3):
            mean[axis, i] += share[k] * innovation[axis]
            square[axis, i] += share[k] * innovation[axis] ** 2
            noise[axis, i] += share[k] * sigma[axis] ** 2
    return strongest, seen, chance, mean, square, noise


@kernel
def _tell_what_holds_for_any(
    made: EchoRows, hypotheses: Hypotheses, told: tuple[Floats, Indices, Indices], echoes: EchoRows
) -> None:
    """Set elevation, its reach and the cut of each echo `made`, for each of k objects, so that no rival is ruled out.

    `told`: probability of each pair (p,), the strongest pair of each object (n,), the k objects. One cut off that may
    be the object's own moves the middle by an error that stays, so the middle counts as cut off: to take a whole echo
    for one loses one image, to take a slide for noise makes a motion of it. Heights are from the lowest to the highest
    that any of the planes leaves open, where planes are told apart.
    """
    share, strongest, objects = told
    place = np.full(len(strongest), -1)
    for k, i in enumerate(objects):
        place[i], j = k, hypotheses.echoes[strongest[i]]
        made.elevation[k], made.half_vertical[k], made.cut[k] = echoes.elevation[j], echoes.half_vertical[j], 0.0
    for pair in range(len(share)):
        i, j = hypotheses.objects[pair], hypotheses.echoes[pair]
        k = place[i]
        if k < 0 or share[pair] < RIVAL * share[strongest[i]]:
            continue
        made.cut[k] = max(made.cut[k], echoes.cut[j])
        if made.half_vertical[k] > 0.0:
            lowest = min(made.elevation[k] - made.half_vertical[k], echoes.elevation[j] - echoes.half_vertical[j])
            highest = max(made.elevation[k] + made.half_vertical[k], echoes.elevation[j] + echoes.half_vertical[j])
            made.elevation[k], made.half_vertical[k] = 0.5 * (lowest + highest), 0.5 * (highest - lowest)


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
