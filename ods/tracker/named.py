"""Tables with named rows: the one way in which structured data goes into the tracker's kernels and comes out.

One array crosses the border, and both sides give its rows their names at once: `RowNames(*table)` here, a kernel of the
record's own there (such as `echo_rows`). A NamedTuple of eight arrays would cost 1.9 us a crossing, as each array is
unpacked by itself; one table costs 0.4 us (ADR 0012).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Mask
from ods.compiled import native

GROWTH = 2
"""Growth factor of a table without room for new objects."""

RowNames = TypeVar("RowNames", bound=tuple[Any, ...])


@dataclass(slots=True, eq=False)
class Named(Generic[RowNames]):
    """A table and its rows by name."""

    record: Callable[..., RowNames]
    """A NamedTuple with a field for each index of the table's first axis."""
    table: Floats
    _rows: RowNames | None = None

    @property
    def rows(self) -> RowNames:
        """Views of the table's rows."""
        if self._rows is None:
            self._rows = self.record(*self.table)
        return self._rows


class TrackTable(Generic[RowNames]):
    """A table with an object a column (the last axis), to append objects to and remove them from.

    Always C-contiguous, as kernels want it, and always at the start of the same memory: `table` and `rows` of before an
    `extend` or `keep` are of no use after it.
    """

    def __init__(self, record: Callable[..., RowNames], shape: tuple[int, ...], dtype: type[Any] = np.float64) -> None:
        """`shape`: of the table without its last axis; `record`: as in `Named`; `dtype`: of 8 bytes."""
        self._record, self._shape, self._dtype = record, shape, dtype
        self.height = math.prod(shape)
        """Numbers an object."""
        self.cells = np.zeros(0, np.int64)
        """Room for the table, and for more objects."""
        self.lay_out(0)

    def __len__(self) -> int:
        return int(self.table.shape[-1])

    def last(self, count: int) -> RowNames:
        """Return views of the rows of the last so many objects, to be filled in."""
        return self._record(*self.table[..., len(self) - count :])

    def restore(self, stored: bytes) -> None:
        """Replace all objects by those of another table of the same record, `table.tobytes()`. Raises ValueError."""
        numbers: NDArray[Any] = np.frombuffer(stored, self._dtype).reshape(*self._shape, -1).copy()
        self.cells = numbers.view(np.int64).ravel()
        self.lay_out(numbers.shape[-1])

    def lay_out(self, count: int) -> None:
        """Take the cells as the table of a number of objects."""
        self.table: NDArray[Any] = self.cells[: self.height * count].view(self._dtype).reshape(*self._shape, count)
        self.rows = self._record(*self.table)
        """Views of the table's rows."""


def extend(tables: list[TrackTable[Any]], count: int) -> None:
    """Append a number of objects to each table, all numbers 0."""
    total = len(tables[0]) + count
    for one in tables:
        if one.height * total > len(one.cells):
            cells = np.zeros(GROWTH * one.height * total, np.int64)
            cells[: one.table.size] = one.table.view(np.int64).ravel()
            one.cells = cells
        native.table_extend(one.cells, one.height, total - count, count)
    for one in tables:
        one.lay_out(total)


def keep(tables: list[TrackTable[Any]], mask: Mask) -> None:
    """Remove the objects where (n,) `mask` is False from each table; the others keep their order."""
    left = [native.table_keep(one.cells, one.height, mask) for one in tables]
    for one, count in zip(tables, left, strict=True):
        one.lay_out(count)


def each(*rows: Floats) -> tuple[Floats, ...]:
    """Return a table's rows, which have no names: a record for `TrackTable`."""
    return rows
