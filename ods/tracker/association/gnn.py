"""Global nearest neighbour: one echo an object at most, the assignment with the largest sum of scores."""

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled import native
from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.hypotheses.gating import Hypotheses
from ods.tracker.linear_assignment import best_columns


def nearest(question: Question) -> Assignment:
    """See `ods.tracker.association.registry.Association`; the predictions are not needed again."""
    echoes = question.echoes
    pairs = best_pairs(question.hypotheses, question.first, len(echoes))
    explained = np.zeros(len(echoes), bool)
    explained[pairs.echoes] = True
    return Assignment(pairs, echoes.take(pairs.echoes), explained)


def best_pairs(hypotheses: Hypotheses, first: Mask, echoes: int) -> Hypotheses:
    """Give each object at most one echo and each echo to at most one object; return the pairs.

    The objects of the mask `first` choose before the others; within each group the sum of scores, all above 0, is the
    largest possible. `echoes`: how many there are.
    """
    if not len(hypotheses.score):
        return hypotheses
    hypotheses = hypotheses.plain()
    chosen, taken = np.zeros(len(hypotheses.score), bool), np.zeros(echoes, bool)
    rivals = np.empty(len(hypotheses.score), np.intp)
    for group in (first, ~first):
        count = native.gnn_undisputed(hypotheses, group, taken, chosen, rivals)
        if count:
            settle(hypotheses, rivals[:count], len(first), echoes, chosen)
        taken[hypotheses.echoes[chosen]] = True
    return hypotheses.take(chosen)


def settle(hypotheses: Hypotheses, disputed: Indices, objects: int, echoes: int, chosen: Mask) -> None:
    """Mark in `chosen` (p,) those of the `disputed` pairs whose sum of scores is the largest possible."""
    matrix, rows, columns = _matrix(hypotheses, disputed, objects, echoes)
    chosen[disputed] = best_columns(matrix)[rows] == columns


def _matrix(
    hypotheses: Hypotheses, pairs: Indices, all_objects: int, all_echoes: int
) -> tuple[Floats, Indices, Indices]:
    """Return a matrix with the scores of `pairs`, 0 elsewhere, and in which row and column of it each of them is."""
    rows, columns, size = np.empty_like(pairs), np.empty_like(pairs), np.empty(2, np.intp)
    native.gnn_places(hypotheses, pairs, all_objects, all_echoes, rows, columns, size)
    matrix = np.zeros(size)
    matrix[rows, columns] = hypotheses.score[pairs]
    return matrix, rows, columns
