"""Tables with named rows: the one way in which structured data goes into the tracker's kernels and comes out.

One array crosses the border, and both sides give its rows their names at once: `RowNames(*table)` here, a kernel of the
record's own there (such as `echo_rows`). A NamedTuple of eight arrays would cost 1.9 us a crossing, as each array is
unpacked by itself; one table costs 0.4 us (ADR 0012).
"""

import math
from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Mask
from ods.compiled import native

GROWTH = 2
"""Growth factor of a table without room for new objects."""

RowNames = TypeVar("RowNames", bound=tuple[Any, ...])


class Named(Generic[RowNames]):
    """A table and its rows by name."""

    __slots__ = ("_record", "_rows", "table")

    def __init__(self, record: Callable[..., RowNames], table: Floats) -> None:
        """`record`: a NamedTuple with a field for each index of the table's first axis."""
        self.table = table
        self._record = record
        self._rows: RowNames | None = None

    @property
    def rows(self) -> RowNames:
        """Views of the table's rows."""
        if self._rows is None:
            self._rows = self._record(*self.table)
        return self._rows


class TrackTable(Generic[RowNames]):
    """A table with an object a column (the last axis), to append objects to and remove them from.

    Always C-contiguous, as kernels want it, and always at the start of the same memory: `table` and `rows` of before a
    `grow` or `keep` are of no use after it.
    """

    def __init__(self, record: Callable[..., RowNames], shape: tuple[int, ...], dtype: type[Any] = np.float64) -> None:
        """`shape`: of the table without its last axis; `record`: as in `Named`; `dtype`: of 8 bytes."""
        self._record = record
        self._rows: RowNames | None = None
        self._shape, self._dtype, self._height = shape, dtype, math.prod(shape)
        self._cells = np.zeros(0, np.int64)
        """Room for the table, and for more objects."""
        self.table: NDArray[Any] = np.zeros((*shape, 0), dtype)

    @property
    def rows(self) -> RowNames:
        """Views of the table's rows."""
        if self._rows is None:
            self._rows = self._record(*self.table)
        return self._rows

    def __len__(self) -> int:
        return int(self.table.shape[-1])

    def extend(self, count: int) -> None:
        """Append a number of objects, all numbers 0."""
        old = len(self)
        if self._height * (old + count) > len(self._cells):
            self._cells = np.zeros(GROWTH * self._height * (old + count), np.int64)
            self._cells[: self.table.size] = self.table.view(np.int64).ravel()
        native.table_extend(self._cells, self._height, old, count)
        self._has(old + count)

    def grow(self, count: int) -> RowNames:
        """Append a number of objects, all numbers 0, and return their rows to be filled in."""
        old = len(self)
        self.extend(count)
        return self._record(*self.table[..., old:])

    def restore(self, stored: bytes) -> None:
        """Replace all objects by those of another table of the same record, `table.tobytes()`. Raises ValueError."""
        numbers: NDArray[Any] = np.frombuffer(stored, self._dtype).reshape(*self._shape, -1).copy()
        self._cells = numbers.view(np.int64).ravel()
        self._has(numbers.shape[-1])

    def keep(self, mask: Mask) -> None:
        """Remove the objects where (n,) `mask` is False; the others keep their order."""
        self._has(native.table_keep(self._cells, self._height, mask))

    def _has(self, count: int) -> None:
        """Lay the table out again, for a number of objects."""
        self.table = self._cells[: self._height * count].view(self._dtype).reshape(*self._shape, count)
        self._rows = None


def each(*rows: Floats) -> tuple[Floats, ...]:
    """Return a table's rows, which have no names: a record for `TrackTable`."""
    return rows
