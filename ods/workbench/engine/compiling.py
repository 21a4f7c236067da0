"""What numba compiles now, for who waits for it: where `ods compile` has not been."""

import math
import time

from ods.compiled import kernel

LONGEST_S = 15.0
"""One kernel takes less."""


class Compiling:
    """The kernels compiled since the start."""

    def __init__(self) -> None:
        self._count = 0
        self._since = -math.inf

    def hear(self) -> None:
        """Be told from now on."""
        kernel.tell_compiling(self.take)

    def take(self, count: int, _name: str) -> None:
        """Take in that a kernel is about to be compiled; it and those before it are `count`."""
        self._count, self._since = count, time.monotonic()

    def words(self) -> str:
        """Say that it happens, and that it is for once; "" where nothing is compiled."""
        if time.monotonic() > self._since + LONGEST_S:
            return ""
        return f"compiling for the first time, half a minute or so: {self._count} kernels so far"


COMPILING = Compiling()
"""Of this process: numba has one compiler."""
