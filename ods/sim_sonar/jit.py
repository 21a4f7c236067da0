"""The typed doorway to numba: functions compiled at first use and cached beside their source."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile `function` in no-python mode; other threads run on.

    IEEE rules are kept but for the order of sums: the same machine gives the same bytes. Division by zero gives inf.
    """
    rules = {"reassoc", "contract", "nsz"}
    return cast(F, numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=rules)(function))
