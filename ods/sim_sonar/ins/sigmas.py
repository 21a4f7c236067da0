"""The standard deviations that a simulated INS reports."""

from typing import NamedTuple

from numpy.typing import ArrayLike


class Sigmas(NamedTuple):
    """Those of one pose epoch."""

    position: ArrayLike = (0.1, 0.1, 0.1)
    """(3,) north, east, down, m."""
    attitude: ArrayLike = (0.002, 0.002, 0.005)
    """(3,) roll, pitch, yaw, rad."""
    over_bottom: float = 0.1
    """Of the height over the bottom, m: the only one that is also added to the reported value as noise."""


USUAL_SIGMAS = Sigmas()
