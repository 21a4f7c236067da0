"""The bottom in a range image: a plane under the sonar, found by random sample consensus and fitted to what agrees.

M. Fischler and R. Bolles, Communications of the ACM 24(6), 1981. The samples are the same for the same image.
"""

import math

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.pipeline.range_image.points import RangePixels

TRIALS = 64
MOST_POINTS, FEWEST_POINTS = 1024, 60
STEEPEST = math.tan(math.radians(30.0))
"""Slope of a bottom."""
UNDER_M = 0.2
"""Least depth of the bottom under the sonar, m."""
LEAST_SHARE, MOST_BELOW = 0.3, 0.05
"""Least share of the points under the sonar that lie in the bottom, and largest share below it."""


def bottom_of(pixels: RangePixels, tolerance_m: float) -> Mask:
    """Return (bearings, elevations) which pixels show an even bottom, or what is no higher over it than the tolerance.

    None where there is no such bottom.
    """
    nothing = np.zeros_like(pixels.wanted)
    points = pixels.points_ned - pixels.position
    under = pixels.wanted & (points[..., 2] > UNDER_M)
    if tolerance_m <= 0.0 or np.count_nonzero(under) < FEWEST_POINTS:
        return nothing
    rng = np.random.default_rng(0)
    found = points[under]
    few = found[rng.integers(len(found), size=MOST_POINTS)] if len(found) > MOST_POINTS else found
    plane = _best_plane(few, tolerance_m, rng)
    if plane is None:
        return nothing
    plane = _fitted(few[np.abs(_height(few, plane)) <= tolerance_m])
    low = pixels.wanted & (_height(points, plane) <= tolerance_m)
    return np.asarray(low & _lies_flat(points, low)[:, None])


def _lies_flat(points: Floats, low: Mask) -> Mask:
    """Return (bearings,) bool: low points spread more in distance than in height; the foot of a wall does not."""
    away = np.hypot(points[..., 0], points[..., 1])
    return np.asarray(_spread(away, low) >= _spread(points[..., 2], low))


def _spread(values: Floats, chosen: Mask) -> Floats:
    return np.asarray(np.where(chosen, values, -np.inf).max(axis=1) - np.where(chosen, values, np.inf).min(axis=1))


def _best_plane(points: Floats, tolerance_m: float, rng: np.random.Generator) -> Floats | None:
    """Return the plane, down = a + b north + c east, that most points agree with; None: there is no bottom."""
    triples = points[rng.integers(len(points), size=(TRIALS, 3))]
    matrix = np.concatenate([np.ones((TRIALS, 3, 1)), triples[..., :2]], axis=2)
    sound = np.abs(np.linalg.det(matrix)) > 1e-3
    if not sound.any():
        return None
    planes = np.linalg.solve(matrix[sound], triples[sound][..., 2:])[..., 0]
    planes = planes[np.hypot(planes[:, 1], planes[:, 2]) <= STEEPEST]
    if not len(planes):
        return None
    heights = planes[:, :1] + planes[:, 1:] @ points[:, :2].T - points[:, 2]
    agree = np.count_nonzero(np.abs(heights) <= tolerance_m, axis=1)
    best = int(np.argmax(agree))
    below = np.count_nonzero(heights[best] < -tolerance_m)
    if agree[best] < LEAST_SHARE * len(points) or below > MOST_BELOW * len(points):
        return None
    return np.asarray(planes[best])


def _fitted(points: Floats) -> Floats:
    matrix = np.column_stack([np.ones(len(points)), points[:, :2]])
    return np.asarray(np.linalg.lstsq(matrix, points[:, 2], rcond=None)[0])


def _height(points: Floats, plane: Floats) -> Floats:
    """Return (...) how high (..., 3) points are over a plane, m."""
    return np.asarray(plane[0] + points[..., :2] @ plane[1:] - points[..., 2])
