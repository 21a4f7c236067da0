"""The object's shape as seen in an echo (circle.h)."""

from typing import NamedTuple


class Shape(NamedTuple):
    """What an echo shows of its body's shape."""

    whole: float
    """1: all of it; 0: its front."""
    roundness: float
    """1: a convex front; 0: a flat one."""
    long_m: float
    """Along the line of sight."""
    wide_m: float
    """Across it, without the beam's width."""
    blur_m: float
    """Width of the beam there."""
    beams: int
    contrast: float
    """Highest level over the mean of the lower ends of its runs: over a rough sea-bed an echo ends at higher levels."""
    beside_m: float
    """Largest standard deviation of its place across the line of sight,"""
    behind_m: float
    """and, where it is of a whole body, of how far the circle's centre is behind the near edge."""
