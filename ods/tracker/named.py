"""Tables with named rows: the one way in which structured data goes into the tracker's kernels and comes out.

One array crosses the border, and both sides give its rows their names at once: `RowNames(*table)` here, a kernel of the
record's own there (such as `echo_rows`). A NamedTuple of eight arrays would cost 1.9 us a crossing, as each array is
unpacked by itself; one table costs 0.4 us (ADR 0012).
"""

from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats, Mask

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

    Always C-contiguous, as kernels want it; `table` and `rows` are other arrays after each `grow` or `keep`.
    """

    def __init__(self, record: Callable[..., RowNames], shape: tuple[int, ...], dtype: type[Any] = np.float64) -> None:
        """`shape`: of the table without its last axis; `record`: as in `Named`."""
        self._record = record
        self._rows: RowNames | None = None
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
        """Append so many objects, all numbers 0."""
        old = len(self)
        larger = np.zeros((*self.table.shape[:-1], old + count), self.table.dtype)
        larger[..., :old] = self.table
        self.table, self._rows = larger, None

    def grow(self, count: int) -> RowNames:
        """Append so many objects, all numbers 0, and return their rows to be filled in."""
        old = len(self)
        self.extend(count)
        return self._record(*self.table[..., old:])

    def restore(self, stored: bytes) -> None:
        """Replace all objects by those of another table of the same record, `table.tobytes()`. Raises ValueError."""
        numbers: NDArray[Any] = np.frombuffer(stored, self.table.dtype)
        self.table, self._rows = numbers.reshape(*self.table.shape[:-1], -1).copy(), None

    def keep(self, mask: Mask) -> None:
        """Remove the objects where (n,) `mask` is False; the others keep their order."""
        self.table, self._rows = self.table.take(mask.nonzero()[0], axis=-1), None  # half the time of `compress`


def each(*rows: Floats) -> tuple[Floats, ...]:
    """Return a table's rows, which have no names: a record for `TrackTable`."""
    return rows
