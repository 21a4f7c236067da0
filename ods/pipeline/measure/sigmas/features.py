"""Dimensionless features that determine how well an echo's circle is known.

Each is held to what echoes of bodies have: beyond, the law (laws.npz) says what it says at the border.
"""

from typing import NamedTuple


class Features(NamedTuple):
    """Of an echo; logarithms are natural ones."""

    middle: float
    """Where in its depth the middle of its intensity lies: 0 halfway, 1 a tenth of the depth further, -1 nearer."""
    whole: float
    """1: all of its body is seen; 0: a front."""
    roundness: float
    """Of the front."""
    depth: float
    """Logarithm of the depth over the width of a point,"""
    radius: float
    """of the circle's radius over that,"""
    behind: float
    """of how far the circle's middle is behind the near edge over its radius,"""
    aspect: float
    """and of depth over width."""
    resolved: float
    """Share of the square of the width in its sum with the square of the beam's width."""
    blur: float
    """Logarithm of the beam's width over that of a point,"""
    beams: float
    """of the number of beams,"""
    rise: float
    """of how far the first crest lies behind the near edge, over the width of a point,"""
    peak: float
    """of the highest level in multiples of the background,"""
    mean: float
    """and of the mean level over that."""
    fill: float
    """Share of the cells of its depth and beams that are the echo's."""
    contrast: float
    """Logarithm of the highest level over that of the outermost cells. Only the range's law has it."""
