"""Joint probabilistic data association (JPDA): an object is corrected by all echoes that may be its own.

Joint probabilistic data association, with the marginal probabilities by belief propagation: J. L. Williams and
R. A. Lau, Approximate evaluation of marginal association probabilities with belief propagation, IEEE Trans. AES 50(4),
2014. They are exact where the pairs make no loops. The echoes of an object are then put together to one at their
middle, whose noise is such that the ordinary update ends in the variance of probabilistic data association:
Y. Bar-Shalom, F. Daum, J. Huang, The probabilistic data association filter, IEEE Control Systems 29(6), 2009.
"""

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.gnn import settle
from ods.tracker.association.hypotheses.gating import Hypotheses
from ods.tracker.measurement.scan import Echoes

LEAST_GAIN = 0.05
"""Least gain of an object with ambiguous echoes far apart, as a share of the gain of a certain echo."""


def probabilistic(question: Question) -> Assignment:
    """See `ods.tracker.association.registry.Association`.

    Only the objects that choose first share echoes. The others often compete to be the same object: they take
    one echo each, from what is left.
    """
    hypotheses, first, echoes, predicted, estimate = question
    n, m, most = len(first), echoes.table.shape[1], min(len(hypotheses.score), len(first))
    explained, chosen = np.empty(m, np.bool_), np.empty(len(hypotheses.score), np.bool_)
    best, llr, made = np.empty(most, np.intp), np.empty(most), np.empty((len(echoes.table), most))
    disputed, counts = np.empty(len(hypotheses.score), np.intp), np.empty(2, np.intp)
    objects = first, echoes.table, predicted.table, estimate.radius, estimate.radius_variance
    seen_by = best, llr, made
    native.jpda_share_out(hypotheses, objects, LEAST_GAIN, explained, seen_by, chosen, disputed, counts)
    seen, rivals = counts.tolist()
    if rivals:
        settle(hypotheses, disputed[:rivals], n, m, chosen)
    total = seen + int(np.count_nonzero(chosen))
    pairs = Hypotheses(*np.empty((2, total), np.intp), *np.empty((2, total)))
    table = np.empty((len(echoes.table), total))
    native.jpda_assignment(hypotheses, echoes.table, seen_by, chosen, explained, pairs, table)
    return Assignment(pairs, Echoes(table), explained)


def association_probabilities(hypotheses: Hypotheses, objects: int, echoes: int) -> tuple[Floats, Floats]:
    """Return (p,) the probability of each pair, and (p,) that its echo is of no other object."""
    share, free = np.empty((2, len(hypotheses.score)))
    native.jpda_shares(hypotheses.plain(), objects, echoes, share, free)
    return share, free
