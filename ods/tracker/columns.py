"""Growing tables of numbers: one row a quantity, one column an object, so that a step works on all objects at once."""

from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Number = TypeVar("Number", np.float64, np.int64)


class Columns(Generic[Number]):
    """A (rows, objects) table that objects are appended to and removed from, without a copy for each of them."""

    def __init__(self, rows: int, dtype: type[Number], capacity: int = 64) -> None:
        self._store: NDArray[Number] = np.zeros((rows, capacity), dtype)
        self.data: NDArray[Number] = self._store[:, :0]
        """(rows, objects) view; valid until the next `append` or `keep`."""

    def __len__(self) -> int:
        return int(self.data.shape[1])

    def append(self, values: NDArray[Number]) -> None:
        """Add (rows, k) new columns at the end."""
        old, count = len(self), len(self) + values.shape[1]
        if count > self._store.shape[1]:
            larger = np.zeros((self._store.shape[0], 2 * count), self._store.dtype)
            larger[:, :old] = self.data
            self._store = larger
        self._store[:, old:count] = values
        self.data = self._store[:, :count]

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Remove the columns where (objects,) `mask` is False; the others keep their order."""
        kept = self.data[:, mask]
        self.data = self._store[:, : kept.shape[1]]
        self.data[...] = kept
