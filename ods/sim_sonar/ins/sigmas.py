"""The standard deviations that a simulated INS tells."""

from typing import NamedTuple

from numpy.typing import ArrayLike


class Sigmas(NamedTuple):
    """Those of one pose epoch."""

    position: ArrayLike = (0.1, 0.1, 0.1)
    """(3,) north, east, down, m."""
    attitude: ArrayLike = (0.002, 0.002, 0.005)
    """(3,) roll, pitch, yaw, rad."""


USUAL_SIGMAS = Sigmas()
