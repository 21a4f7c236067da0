"""Growing tables of numbers: one row a quantity, one column an object, so that a step works on all objects at once."""

from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", np.float64, np.int64)


class Columns(Generic[Number]):
    """A (rows, objects) table that objects are appended to and removed from, without a copy for each of them."""

    def __init__(self, rows: int, dtype: type[Number], capacity: int = 64) -> None:
        self._store: NDArray[Number] = np.zeros((rows, capacity), dtype)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def data(self) -> NDArray[Number]:
        """(rows, objects) view; valid until the next `append` or `keep`."""
        return self._store[:, : self._count]

    def append(self, values: NDArray[Number]) -> None:
        """Add (rows, k) new columns at the end."""
        count = self._count + values.shape[1]
        if count > self._store.shape[1]:
            larger = np.zeros((self._store.shape[0], 2 * count), self._store.dtype)
            larger[:, : self._count] = self.data
            self._store = larger
        self._store[:, self._count : count] = values
        self._count = count

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Remove the columns where (objects,) `mask` is False; the others keep their order."""
        kept = self.data[:, mask]
        self._count = kept.shape[1]
        self._store[:, : self._count] = kept
