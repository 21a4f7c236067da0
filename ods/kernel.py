"""The one way this package compiles: numba, cached on disk, NaN and infinity kept as IEEE 754 has them."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])

_FASTMATH = {"reassoc", "contract", "arcp", "nsz"}
"""Sums may be reordered, so that they vectorise. Not `nnan`, not `ninf`: bad samples must compare as false."""


def kernel(function: F) -> F:
    """Compile `function` at its first call for the array types it is given; later runs load it from the cache."""
    return cast(F, njit(cache=True, fastmath=_FASTMATH, error_model="numpy")(function))
