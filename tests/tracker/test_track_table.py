"""Tables with an object a column: in place they are what numpy makes of copies."""

import numpy as np
import pytest

from ods.compiled import native
from ods.tracker.named import TrackTable, TrackTables, each


def test_columns_are_appended_and_removed_as_numpy_does_it() -> None:
    rng = np.random.default_rng(0)
    tables = [TrackTable(each, shape) for shape in ((1,), (3,), (2, 5))]
    columns, expected = TrackTables(tables), [one.table.copy() for one in tables]
    for _ in range(400):
        count, kept = int(rng.integers(0, 6)), rng.choice([0.0, 0.5, 0.8, 1.0])
        columns.extend(count)
        mask = rng.random(len(tables[0])) < kept
        for k, one in enumerate(tables):
            assert not one.table[..., len(one) - count :].any()
            one.table[..., len(one) - count :] = rng.standard_normal((*one.table.shape[:-1], count))
            expected[k] = np.concatenate([expected[k], one.table[..., len(one) - count :]], axis=-1)[..., mask]
        columns.keep(mask)
        for one, wanted in zip(tables, expected, strict=True):
            assert one.table.flags.c_contiguous
            np.testing.assert_array_equal(one.table, wanted)


def test_restored_tables_grow_and_shrink() -> None:
    numbers, ids = TrackTable(each, (2,)), TrackTable(each, (1,), np.int64)
    columns = TrackTables([numbers, ids])
    columns.restore([np.arange(8.0).tobytes(), np.arange(4).tobytes()])
    columns.keep(np.array([True, False, True, True]))
    columns.extend(1)
    numbers.last(1)[1][:] = 9.0
    np.testing.assert_array_equal(numbers.table, [[0, 2, 3, 0], [4, 6, 7, 9]])
    np.testing.assert_array_equal(ids.table, [[0, 2, 3, 0]])


def test_tables_of_different_numbers_of_objects_are_refused() -> None:
    columns = TrackTables([TrackTable(each, (2,)), TrackTable(each, (1,))])
    for stored in ([np.zeros(8), np.zeros(3)], [np.zeros(7), np.zeros(3)], [np.zeros(8)]):
        with pytest.raises(ValueError, match=r"dimensions|reshape|zip"):
            columns.restore([own.tobytes() for own in stored])


def test_kernels_leave_memory_alone_that_is_not_the_table_s() -> None:
    cells = np.arange(6)
    assert native.table_keep(cells, 2, np.ones(4, np.bool_)) < 0
    assert not native.table_extend(cells, 2, 3, 1)
    np.testing.assert_array_equal(cells, np.arange(6))
