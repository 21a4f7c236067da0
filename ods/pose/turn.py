"""By how much a vehicle turned between two poses."""

import math

from ods.messages import Pose


def turn_between(a: Pose, b: Pose) -> float:
    """Return the angle between two attitudes, about whatever axis, rad."""
    cosine = abs(sum(p * q for p, q in zip(a.attitude, b.attitude, strict=True)))
    return 2.0 * math.acos(min(cosine, 1.0))
