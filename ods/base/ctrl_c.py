"""Ctrl-C that comes while a C library calls Python back, as a compiler does: there it is printed and lost."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


class CtrlC:
    """What became of it."""

    def __init__(self) -> None:
        self.swallowed = False
        """It was lost: what the library, or who called it, complains of after it is no fault."""


@contextmanager
def ctrl_c_noted() -> Iterator[CtrlC]:
    """Note Ctrl-C that is lost, instead of printing where."""
    noted, before = CtrlC(), sys.unraisablehook

    def hook(told: Any) -> None:
        if told.exc_type is KeyboardInterrupt:
            noted.swallowed = True
        else:
            before(told)

    sys.unraisablehook = hook
    try:
        yield noted
    finally:
        sys.unraisablehook = before
