"""Errors that do not average out over pings, the height and the bias of the pose, beside the filters:
`sensitivity.h`."""

from typing import NamedTuple

from ods.base.arrays import Floats

STATE = 4
"""Rows of a state: north, east and their velocities."""
VELOCITY = 2
"""First of the rows of the velocities."""


class Heights(NamedTuple):
    """What an echo's place in the fan says of the heights of the k objects seen: (2, k), static and moving."""

    height: Floats
    variance: Floats
    square: Floats
    """What was learned of the square of the height, about that mean: its mean, m^2,"""
    square_variance: Floats
    """and its variance, m^4."""
    step: Floats
    """By which the height changed."""
