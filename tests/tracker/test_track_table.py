"""Tables with an object a column: in place they are what numpy makes of copies."""

import numpy as np
import pytest

from ods.compiled import native
from ods.tracker.named import TrackTable, each, extend, keep


@pytest.mark.parametrize("shape", [(), (3,), (2, 5)])
def test_columns_are_appended_and_removed_as_numpy_does_it(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(len(shape))
    table, expected = TrackTable(each, shape), np.zeros((*shape, 0))
    for _ in range(200):
        count = int(rng.integers(0, 6))
        new = rng.standard_normal((*shape, count))
        extend([table], count)
        assert not table.table[..., len(table) - count :].any()
        table.table[..., len(table) - count :] = new
        expected = np.concatenate([expected, new], axis=-1)
        kept = rng.random(len(table)) < rng.choice([0.0, 0.5, 0.8, 1.0])
        keep([table], kept)
        expected = expected[..., kept]
        assert table.table.flags.c_contiguous
        np.testing.assert_array_equal(table.table, expected)


def test_a_restored_table_grows_and_shrinks() -> None:
    table = TrackTable(each, (2,), np.int64)
    table.restore(np.arange(8).tobytes())
    keep([table], np.array([True, False, True, True]))
    extend([table], 1)
    table.last(1)[1][:] = 9
    np.testing.assert_array_equal(table.table, [[0, 2, 3, 0], [4, 6, 7, 9]])


def test_kernels_leave_memory_alone_that_is_not_the_table_s() -> None:
    cells = np.arange(6)
    assert native.table_keep(cells, 2, np.ones(4, np.bool_)) < 0
    assert not native.table_extend(cells, 2, 3, 1)
    np.testing.assert_array_equal(cells, np.arange(6))
