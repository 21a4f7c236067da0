"""Compilation of the simulator's functions."""

from collections.abc import Callable
from typing import Any, TypeVar

from ods.compiled import kernel

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile `function` in no-python mode; other threads run on.

    IEEE rules are kept but for the order of sums: the same machine gives the same bytes. Division by zero gives inf.
    """
    return kernel.compiled(function, nogil=True, fastmath={"reassoc", "contract", "nsz"})
