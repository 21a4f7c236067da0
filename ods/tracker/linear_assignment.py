"""Linear assignment by shortest augmenting paths: the pairs with the largest sum of gains."""

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.compiled import native


def best_columns(gain: Floats) -> Indices:
    """Return the column (rows,) that each row of `gain` (rows, columns) is given; -1: none, where columns are fewer.

    The sum of gains is the largest that this number of pairs can have. Of several such assignments it returns the one
    that scipy.optimize.linear_sum_assignment returns. Raises ValueError where a row has no finite gain.
    """
    rows, columns = gain.shape
    if rows <= columns:
        return _cheapest_columns(np.ascontiguousarray(-gain))
    column_of = np.full(rows, -1)
    column_of[_cheapest_columns(np.ascontiguousarray(-gain.T))] = np.arange(columns)
    return column_of


def _cheapest_columns(cost: Floats) -> Indices:
    """Return the column (rows,) of each row of `cost` (rows, columns >= rows) that makes the sum of costs the least."""
    column_of = np.empty(len(cost), np.intp)
    if not native.assign_columns(cost, column_of):
        raise ValueError("a row has no finite gain")
    return column_of
