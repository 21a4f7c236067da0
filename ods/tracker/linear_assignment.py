"""Who gets what, so that the sum of gains is the largest possible: linear assignment by shortest augmenting paths.

R. Jonker, A. Volgenant: A shortest augmenting path algorithm for dense and sparse linear assignment problems, Computing
38, 1987; for rectangular matrices as in D. F. Crouse: On implementing 2D rectangular assignment algorithms, IEEE Trans.
Aerospace and Electronic Systems 52, 2016.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.compiled.kernel import compiled

NONE = -1


class _State(NamedTuple):
    """What is assigned so far, and the dual variables that prove it the best."""

    column_of: Indices
    """(rows,), -1: none."""
    row_of: Indices
    """(columns,), -1: none."""
    row_dual: Floats
    column_dual: Floats


class _Paths(NamedTuple):
    """Shortest paths of one search from a row without a column."""

    length: Floats
    """(columns,) to each column."""
    before: Indices
    """(columns,) row before each column."""
    order: Indices
    """(columns,) those not reached yet, then those reached."""


def best_columns(gain: Floats) -> Indices:
    """Return the column (rows,) that each row of `gain` (rows, columns) is given; -1: none, where columns are fewer.

    The sum of gains is the largest that so many pairs can have. Of several such assignments it returns the one that
    scipy.optimize.linear_sum_assignment returns. Raises ValueError where a row has no gain that is a finite number.
    """
    rows, columns = gain.shape
    if rows <= columns:
        return _cheapest_columns(np.ascontiguousarray(-gain))
    column_of = np.full(rows, NONE)
    column_of[_cheapest_columns(np.ascontiguousarray(-gain.T))] = np.arange(columns)
    return column_of


@compiled
def _cheapest_columns(cost: Floats) -> Indices:
    """Return the column (rows,) of each row of `cost` (rows, columns >= rows) that makes the sum of costs the least."""
    rows, columns = cost.shape
    state = _State(np.full(rows, NONE), np.full(columns, NONE), np.zeros(rows), np.zeros(columns))
    paths = _Paths(np.empty(columns), np.empty(columns, np.intp), np.empty(columns, np.intp))
    for start in range(rows):
        reached = _search(cost, start, state, paths)
        _update_duals(start, reached, state, paths)
        _augment(start, reached[0], state, paths.before)
    return state.column_of


@compiled
def _search(cost: Floats, start: int, state: _State, paths: _Paths) -> Indices:
    """Return the columns reached from row `start`, the last one, a free one, first."""
    columns = len(paths.order)
    for column in range(columns):
        paths.length[column], paths.order[column] = np.inf, columns - 1 - column
    row, shortest = start, 0.0
    for left in range(columns, 0, -1):
        nearest = -1
        least = np.inf
        for place in range(left):
            column = paths.order[place]
            length = shortest + cost[row, column] - state.row_dual[row] - state.column_dual[column]
            if length < paths.length[column]:
                paths.length[column], paths.before[column] = length, row
            length = paths.length[column]
            if length < least or (length == least and state.row_of[column] == NONE):
                nearest, least = place, length
        if least == np.inf:
            break
        column, shortest = paths.order[nearest], least
        paths.order[nearest], paths.order[left - 1] = paths.order[left - 1], column
        row = state.row_of[column]
        if row == NONE:
            return paths.order[left - 1 :]
    raise ValueError("a row has no gain that is a finite number")


@compiled
def _update_duals(start: int, reached: Indices, state: _State, paths: _Paths) -> None:
    shortest = paths.length[reached[0]]
    state.row_dual[start] += shortest
    for column in reached[1:]:
        state.column_dual[column] -= shortest - paths.length[column]
        state.row_dual[state.row_of[column]] += shortest - paths.length[column]


@compiled
def _augment(start: int, column: int, state: _State, before: Indices) -> None:
    """Give each row of the path from row `start` to the free `column` the column behind it."""
    row = NONE
    while row != start:
        row = before[column]
        state.row_of[column] = row
        state.column_of[row], column = column, state.column_of[row]
