"""Global nearest neighbour: one echo an object at most, the assignment with the largest sum of scores."""

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled.kernel import kernel
from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.gating import Hypotheses
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
    chosen, taken = np.zeros(len(hypotheses.score), bool), np.zeros(echoes, bool)
    for group in (first, ~first):
        disputed = _undisputed(hypotheses, group, taken, chosen)
        if len(disputed):
            matrix, rows, columns = _matrix(hypotheses, disputed, len(first), echoes)
            chosen[disputed] = best_columns(matrix)[rows] == columns
        taken[hypotheses.echoes[chosen]] = True
    return hypotheses.take(chosen)


@kernel
def _undisputed(hypotheses: Hypotheses, group: Mask, taken: Mask, chosen: Mask) -> Indices:
    """Mark in `chosen` the pairs of the objects of `group` that have no rival; return those that have.

    Left out are echoes `taken` and scores not above 0.
    """
    objects, echoes, score = hypotheses.objects, hypotheses.echoes, hypotheses.score
    of_object, of_echo = np.zeros(len(group), np.intp), np.zeros(len(taken), np.intp)
    possible, members = np.empty(len(score), np.intp), 0
    for k in range(len(score)):
        if score[k] > 0.0 and group[objects[k]] and not taken[echoes[k]]:
            of_object[objects[k]] += 1
            of_echo[echoes[k]] += 1
            possible[members] = k
            members += 1
    disputed, count = np.empty(members, np.intp), 0
    for k in possible[:members]:
        if of_object[objects[k]] == 1 and of_echo[echoes[k]] == 1:
            chosen[k] = True
        else:
            disputed[count] = k
            count += 1
    return disputed[:count]


@kernel
def _matrix(
    hypotheses: Hypotheses, pairs: Indices, all_objects: int, all_echoes: int
) -> tuple[Floats, Indices, Indices]:
    """Return a matrix with the scores of `pairs`, 0 elsewhere, and in which row and column of it each of them is."""
    objects, echoes = hypotheses.objects, hypotheses.echoes
    row_of, column_of = np.full(all_objects, -1), np.full(all_echoes, -1)
    rows, columns = np.empty(len(pairs), np.intp), np.empty(len(pairs), np.intp)
    height = width = 0
    for p, k in enumerate(pairs):
        if row_of[objects[k]] < 0:
            row_of[objects[k]] = height
            height += 1
        if column_of[echoes[k]] < 0:
            column_of[echoes[k]] = width
            width += 1
        rows[p], columns[p] = row_of[objects[k]], column_of[echoes[k]]
    matrix = np.zeros((height, width))
    for p, k in enumerate(pairs):
        matrix[rows[p], columns[p]] = hypotheses.score[k]
    return matrix, rows, columns
