"""The numbers, without units, that tell how well an echo's circle is known.

Each is held to what echoes of bodies have: beyond, the law (laws.py) says what it says at the border.
"""

import math
from typing import Any, NamedTuple

from ods.compiled.kernel import kernel
from ods.pipeline.measure.circle import Shape
from ods.pipeline.measure.depth import Depth

EchoRecord = Any
"""A row of echoes.ECHO, as kernels get it: numba reads and writes its fields as attributes."""
_LEAST = 0.25
"""Widths of a point; nothing is taken to be shorter or narrower."""


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


@kernel
def features_of(echo: EchoRecord, depth: Depth, shape: Shape, point_m: float, dr_m: float) -> Features:
    """Return the features of an echo, of which levels, extents and circle are filled in.

    point_m: width of a point along the line of sight; dr_m: the columns' spacing.
    """
    least = _LEAST * point_m
    long, wide, radius = max(shape.long_m, least), max(shape.wide_m, least), max(echo.radius_m, 0.5 * least)
    return Features(
        _held((depth.middle - 0.5) / 0.1, -2.0, 2.0),
        shape.whole,
        shape.roundness,
        _held(math.log(long / point_m), -1.5, 4.0),
        _held(math.log(radius / point_m), -2.5, 4.0),
        _held(math.log(max(echo.range_m - echo.near_m, 0.5 * least) / radius), -1.5, 1.0),
        _held(math.log(long / wide), -2.5, 2.5),
        wide**2 / (wide**2 + shape.blur_m**2),
        _held(math.log(max(shape.blur_m, least) / point_m), -1.5, 3.0),
        math.log(min(shape.beams, 30)),
        _held(math.log(max(depth.rise_m, 0.1 * least) / point_m), -2.5, 1.0),
        math.log(_held(echo.peak, 1.5, 20.0)),
        _held(math.log(max(echo.mean, 1e-3) / max(echo.peak, 1e-3)), -2.0, 0.0),
        _held(echo.cells * dr_m / (shape.beams * max(echo.range_extent_m, dr_m)), 0.0, 1.0),
        math.log(_held(shape.contrast, 1.0, 12.0)),
    )  # fmt: skip


@kernel
def _held(value: float, least: float, most: float) -> float:
    """Return a value, or the border that it is beyond."""
    return min(max(value, least), most)
