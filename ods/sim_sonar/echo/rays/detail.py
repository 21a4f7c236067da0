"""Resolution of the mean image: the laws that turn an allowed error into rays, columns and steps."""

import math
from typing import NamedTuple

LEVEL_ERRORS = (0.5, 0.25, 0.12, 0.06, 0.03, 0.015, 0.008, 0.0005)
"""Allowed error of each model level, coarsest first; the last is the converged reference of the others."""


class Detail(NamedTuple):
    """Numerical settings of one level; lengths in correlation lengths of the sea-bed, angles in radians."""

    max_error: float
    """Allowed relative error, rms of the mean image."""
    step: float
    """Along a column of the rough sea-bed, in its correlation lengths."""
    turn: float
    """Largest change of elevation in one step where the sea-bed is near."""
    growth: float
    """Largest step as a share of the distance."""
    spacing: float
    """Between neighbouring columns, in correlation lengths."""
    lean: float
    """Largest change of a flat sea-bed's elevation between tabulated bearings."""
    reach: float
    """Beam widths from a beam's axis beyond which the sea-bed is received as its mean over all bearings."""


def detail_of(max_error: float) -> Detail:
    """Return the settings that keep the smoothed error of the mean image under `max_error`."""
    root = math.sqrt(max_error)
    return Detail(
        max_error=max_error,
        step=1.0 * root,
        turn=0.12 * root,
        growth=0.3 * root,
        spacing=1.6 * root,
        lean=0.03 * root,
        reach=min(0.3 / root, 60.0),
    )
