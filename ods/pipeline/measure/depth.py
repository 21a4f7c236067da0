"""An echo along the line of sight (depth.h)."""

from typing import NamedTuple


class Depth(NamedTuple):
    """An echo along the line of sight."""

    near_m: float
    """Slant range of its nearest point."""
    far_m: float
    rise_m: float
    """From half the level of its first crest to the crest."""
    middle: float
    """Where in its depth, from 0 to 1, the middle of its intensity lies, as it was detected."""
    whole: float
    """1: the echo is of a whole body; 0: it pales behind its front."""
    hidden_m: float
    """Standard deviation of how much nearer the body of a fragment begins; 0 of what is none."""
