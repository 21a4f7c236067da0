"""The numbers, without units, that tell what an echo may be of and how well it is known.

Each is held to what echoes of bodies have: beyond, the laws (laws.py) say what they say at the border.
"""

import math
from typing import NamedTuple

from ods.compiled.kernel import kernel
from ods.pipeline.measure.shape import Shape

_LEAST = 0.25
"""Widths of a point; nothing is taken to be shorter or narrower."""


class Features(NamedTuple):
    """Of an echo; logarithms are natural ones."""

    middle: float
    """Where in its depth the middle of its intensity lies: 0 halfway, 1 a tenth of the depth further, -1 nearer."""
    depth: float
    """Logarithm of the depth over the width of a point."""
    aspect: float
    """Logarithm of depth over width."""
    resolved: float
    """Share of the square of the width in its sum with the square of the beam's width."""
    crest: float
    """Logarithm of the first crest's width over that of a point,"""
    height: float
    """and of its height over the background, in multiples of it."""
    level: float
    """Logarithm of the highest level in multiples of the background."""
    outline: float
    """Logarithm of the radius of the circle around it over its depth,"""
    behind: float
    """and of how far the centre of that is behind the near edge."""
    blur: float
    """Logarithm of the beam's width over that of a point,"""
    beams: float
    """and of the number of beams."""
    roundness: float
    """Of the front."""


@kernel
def features_of(shape: Shape) -> Features:
    """Return the features of an echo of this shape."""
    depth, least = shape.depth, _LEAST * shape.depth.point_m
    long, wide = max(depth.far_m - depth.near_m, least), max(shape.wide_m, least)
    return Features(
        _held((depth.middle - 0.5) / 0.1, -2.0, 2.0),
        _held(math.log(long / depth.point_m), -4.0, 4.0),
        _held(math.log(long / wide), -2.5, 2.5),
        wide**2 / (wide**2 + shape.blur_m**2),
        math.log(_held(depth.width, 0.8, 4.0)),
        math.log(_held(depth.height, 0.3, 20.0)),
        math.log(_held(shape.peak, 1.5, 20.0)),
        _held(math.log(max(shape.outline_m, least) / long), -1.0, 2.5),
        _held(math.log(max(shape.behind_m, 0.4 * least) / long), -2.0, 2.0),
        _held(math.log(max(shape.blur_m, least) / depth.point_m), 0.0, 3.0),
        math.log(min(shape.beams, 30)),
        shape.roundness,
    )


@kernel
def _held(value: float, least: float, most: float) -> float:
    """Return a value, or the border that it is beyond."""
    return min(max(value, least), most)
