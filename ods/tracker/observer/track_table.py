"""Growing tables of numbers: one row a quantity, one column an object, so that a step works on all objects at once."""

from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Mask

Number = TypeVar("Number", np.float64, np.int64)


class Columns(Generic[Number]):
    """A (rows, objects) table to append objects to and remove them from; always C-contiguous, as kernels want it."""

    def __init__(self, rows: int, dtype: type[Number]) -> None:
        self.data: NDArray[Number] = np.zeros((rows, 0), dtype)
        """(rows, objects); another array after each `append` or `keep`."""

    def __len__(self) -> int:
        return int(self.data.shape[1])

    def append(self, values: NDArray[Number]) -> None:
        """Add (rows, k) new columns at the end."""
        old = len(self)
        larger = np.empty((len(self.data), old + values.shape[1]), self.data.dtype)
        larger[:, :old] = self.data
        larger[:, old:] = values
        self.data = larger

    def keep(self, mask: Mask) -> None:
        """Remove the columns where (objects,) `mask` is False; the others keep their order."""
        self.data = self.data.compress(mask, axis=1)
