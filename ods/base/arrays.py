"""The array types of the whole project, by what an element is. Docstrings give shapes, units and frames."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Ints = NDArray[np.int64]
Ints32 = NDArray[np.int32]
Bytes = NDArray[np.uint8]
Indices = NDArray[np.intp]
"""Rows or columns of another array."""
Mask = NDArray[np.bool_]
AnyArray = NDArray[np.generic]
"""Numbers as they come: recorded samples of any type."""
Image = NDArray[np.float32]
"""(beams, samples) amplitudes."""

SAMPLE_DTYPES: dict[str, np.dtype[np.generic]] = {
    "u1": np.dtype(np.uint8),
    "u2": np.dtype("<u2"),
    "f4": np.dtype("<f4"),
}
"""Sample types of a ping, by `Ping.dtype`."""
