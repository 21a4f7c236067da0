"""Where highlights crowd: what stays in its place, and is seen again and again, is no body for that.

A sonar of fine beams, of several planes or of many images a second shows hundreds of highlights of a rough bed a second
where a coarse one shows some ten. Among so many there are always some that are seen in nearly every image, wander no
more than a body, and slide along the bed as if they moved: they are few of the highlights, but many beside the bodies.
So these three say less the more highlights there are; strength and onset, by which such highlights are told, do not.
"""

MANY_A_SECOND = 180.0
"""So many echoes of nothing a second are half a crowd,"""
STEEP = 8.0
"""and those that are fewer than half of these next to none."""


def crowding(echoes: float, dt: float) -> float:
    """Return how much of a crowd, from 0 to 1, so many echoes of nothing are in an image, `dt` s after the last one."""
    if echoes <= 0.0 or dt <= 0.0:
        return 0.0
    return float(1.0 / (1.0 + (MANY_A_SECOND * dt / echoes) ** STEEP))
