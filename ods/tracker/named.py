"""Tables with named rows: the one way in which structured data goes into the tracker's kernels and comes out.

One array crosses the border, and both sides give its rows their names: `RowNames(*table)` here, where they are asked
for, a function of the record's own there (such as `echo_rows`). Of a NamedTuple each array would be unpacked by itself.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Ints, Mask
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
    """A table with an object a column (the last axis), laid out with others in `TrackTables`. C-contiguous."""

    def __init__(self, record: Callable[..., RowNames], shape: tuple[int, ...], dtype: type[Any] = np.float64) -> None:
        """`shape`: of the table without its last axis; `record`: as in `Named`; `dtype`: of 8 bytes."""
        self._record, self._shape, self._dtype = record, shape, dtype
        self.height = math.prod(shape)
        """Numbers an object."""
        self.lay_out(np.zeros(0, np.int64))

    def __len__(self) -> int:
        return int(self.table.shape[-1])

    def last(self, count: int) -> RowNames:
        """Return views of the rows of the last so many objects, to be filled in."""
        return self._record(*self.table[..., len(self) - count :])

    def lay_out(self, cells: Ints) -> None:
        """Take cells as the table's memory, `height` an object."""
        count = len(cells) // self.height
        self.table: NDArray[Any] = cells.view(self._dtype).reshape(*self._shape, count)
        self.rows = self._record(*self.table)
        """Views of the table's rows."""


class TrackTables:
    """Tables of the same objects, one after the other in one memory, to append objects to and remove them from.

    `table` and `rows` of before an `extend`, `keep` or `restore` are of no use after it.
    """

    def __init__(self, tables: list[TrackTable[Any]]) -> None:
        """Take the tables over with the objects that they have."""
        self._tables = tables
        self._height = sum(one.height for one in tables)
        self._cells: Ints
        """Room for the tables, and for more objects."""
        self.restore([one.table.tobytes() for one in tables])

    def extend(self, count: int) -> None:
        """Append a number of objects, all numbers 0."""
        before = len(self._tables[0])
        used, wanted = self._height * before, self._height * (before + count)
        if wanted > len(self._cells):
            cells = np.zeros(GROWTH * wanted, np.int64)
            cells[:used] = self._cells[:used]
            self._cells = cells
        native.table_extend(self._cells, self._height, before, count)
        self._lay_out(before + count)

    def keep(self, mask: Mask) -> None:
        """Remove the objects where (n,) `mask` is False; the others keep their order."""
        self._lay_out(native.table_keep(self._cells, self._height, mask))

    def restore(self, stored: list[bytes]) -> None:
        """Replace all objects by those of tables of the same records, `table.tobytes()` each. Raises ValueError."""
        pairs = zip(self._tables, stored, strict=True)
        numbers = np.concatenate([np.frombuffer(own, np.int64).reshape(one.height, -1) for one, own in pairs])
        self._cells = numbers.ravel()
        self._lay_out(numbers.shape[1])

    def _lay_out(self, count: int) -> None:
        first = 0
        for one in self._tables:
            one.lay_out(self._cells[first : first + one.height * count])
            first += one.height * count


def each(*rows: Floats) -> tuple[Floats, ...]:
    """Return a table's rows, which have no names: a record for `TrackTable`."""
    return rows
