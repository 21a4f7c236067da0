"""What an echo may show of its object, how likely each is, and where and how large the object is then.

A front pales behind its crest [SSIE eq. 3] and is less deep than it is wide. Of a body that shines all over, the middle
of the intensity is the middle, and it is as deep as wide; of one whose near half is lit, the middle is behind, and it
is half as deep as wide. What is flat, or small, is as short as a point.
"""

import math
from typing import NamedTuple

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel
from ods.pipeline.measure.depth import Depth
from ods.pipeline.measure.shape import Shape

_WALL_WIDTHS, _WALL_BEAMS = 2.0, 7
"""From so many beam widths and beams on the echo's front tells a wall that stands askew, which is as deep as a body."""
_NARROWEST = 0.3
"""Beam widths; no flat object is taken to be narrower."""
_AHEAD = 0.3
"""Widths of a point, by which the middle of a flat object's outline lies behind it."""
_LEAST = 0.25
"""Widths of a point; no echo is taken to be shorter."""
_MOST_RATIO = 4.0
"""Logarithm of the largest radius over the echo's depth, and less that of the smallest."""
_MOST_SHIFT = 0.6
"""Of how far the near edge is corrected, in units of `shift_of`."""
_LEAST_HEIGHT = 0.3
"""Of a crest, in multiples of the background."""


class ByKind(NamedTuple):
    """A number for each thing that an echo may show."""

    front: float
    body: float
    half: float
    flat: float


class Body(NamedTuple):
    """An object, m."""

    near_m: float
    """Slant range of its nearest point."""
    behind_m: float
    """How far its centre is behind that."""
    radius_m: float


@kernel
def body_of(shape: Shape, told: Floats) -> Body:
    """Return the mean over what the echo may show.

    told: (8,) logarithms of the probabilities of each kind but for one constant, of the radius over the echo's depth of
    the first three, and how far behind the echo's edge the object begins, in units of `shift_of`.
    """
    point, depth = shape.depth.point_m, shape.depth
    kinds = kinds_of(shape, told)
    radii = _radii(shape, max(depth.far_m - depth.near_m, _LEAST * point), told)
    behind = ByKind(radii.front, radii.body, radii.half, max(shape.behind_m - _AHEAD * point, 0.0))
    shift = min(max(told[7], -_MOST_SHIFT), _MOST_SHIFT) * shift_of(depth)
    return Body(depth.near_m + shift, _mean(kinds, behind), _mean(kinds, radii))


@kernel
def shift_of(depth: Depth) -> float:
    """Return how far, m, speckle moves an edge: the less, the higher the crest behind it is over the background."""
    return depth.point_m / max(depth.height, _LEAST_HEIGHT)


@kernel
def kinds_of(shape: Shape, told: Floats) -> ByKind:
    """Return the probabilities, of sum 1. told: the logarithms of four numbers that are as likely as the kinds."""
    most = max(told[0], told[1], told[2], told[3])
    front, body = math.exp(told[0] - most), math.exp(told[1] - most)
    half, flat = math.exp(told[2] - most), math.exp(told[3] - most)
    total = front + body + half + flat
    kinds = ByKind(front / total, body / total, half / total, flat / total)
    if shape.beams < _WALL_BEAMS or shape.wide_m < _WALL_WIDTHS * shape.blur_m:
        return kinds
    return _or_wall(kinds, shape.roundness)


@kernel
def _or_wall(kinds: ByKind, roundness: float) -> ByKind:
    """Return the probabilities for an echo whose front is so round: a front that is not is of something flat."""
    flat = max(kinds.flat, (1.0 - roundness) * (1.0 - kinds.body))
    left = max(1.0 - kinds.body - flat, 0.0) / max(kinds.front + kinds.half, 1e-9)
    return ByKind(left * kinds.front, kinds.body, left * kinds.half, flat)


@kernel
def _radii(shape: Shape, long: float, told: Floats) -> ByKind:
    """Return the radius, m, that the object has if it is of a kind. long: depth of the echo, m."""
    wide, blur = shape.wide_m, shape.blur_m
    return ByKind(
        long * _ratio(told[4]), long * _ratio(told[5]), long * _ratio(told[6]),
        0.5 * math.sqrt(max(wide**2 - blur**2, (_NARROWEST * blur) ** 2)),
    )  # fmt: skip


@kernel
def _ratio(logarithm: float) -> float:
    return math.exp(min(max(logarithm, -_MOST_RATIO), _MOST_RATIO))


@kernel
def _mean(kinds: ByKind, values: ByKind) -> float:
    total = 0.0
    for i in range(len(kinds)):
        total += kinds[i] * values[i]
    return total
