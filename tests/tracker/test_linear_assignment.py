"""Linear assignment: the same choice as SciPy's, ties included."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from ods.tracker.linear_assignment import best_columns


@pytest.mark.parametrize("kind", ["continuous", "ties", "sparse", "signed"])
def test_the_same_pairs_as_scipy(kind: str) -> None:
    rng = np.random.default_rng(7)
    for _ in range(400):
        shape = tuple(rng.integers(1, 15, 2))
        gain = rng.random(shape) if kind != "ties" else rng.integers(0, 4, shape).astype(float)
        if kind == "sparse":
            gain *= rng.random(shape) < 0.3
        if kind == "signed":
            gain = 100.0 * gain - 50.0
        rows, columns = linear_sum_assignment(gain, maximize=True)
        found = best_columns(gain)
        np.testing.assert_array_equal(np.flatnonzero(found >= 0), rows)
        np.testing.assert_array_equal(found[rows], columns)


def test_no_rows_no_columns() -> None:
    assert best_columns(np.zeros((0, 3))).tolist() == []
    assert best_columns(np.zeros((3, 0))).tolist() == [-1, -1, -1]


def test_numbers_that_are_none_are_refused() -> None:
    with pytest.raises(ValueError, match="finite"):
        best_columns(np.full((2, 2), np.nan))
