"""Labelled images."""

from dataclasses import dataclass, field

import numpy as np

from ods.base.arrays import Floats32
from ods.messages import Detection, Ping

LABEL_MARGIN = 3
"""Cells by which the label's box of a drawn object is wider than its echo."""


@dataclass(frozen=True)
class Target:
    """A labelled object: the box that a detection's centre must lie in, and the true circle where it is known."""

    range_m: tuple[float, float]
    """Nearest and farthest slant range of the box."""
    bearing_rad: tuple[float, float]
    """Its bearings, from port to starboard."""
    circle: tuple[float, float, float] | None = None
    """Slant range, bearing and radius of the body; none: only the box is known."""
    counts: bool = True
    """False: neither finding nor missing it says anything; its detections are no false alarms either."""

    def holds(self, detection: Detection) -> bool:
        """Return whether a detection finds it: its centre lies in the box."""
        (near_m, far_m), (port, starboard) = self.range_m, self.bearing_rad
        return near_m <= detection.range_m <= far_m and port <= detection.bearing_rad <= starboard


@dataclass(frozen=True, eq=False)
class LabelledImage:
    """One ping and the objects in it."""

    ping: Ping
    targets: list[Target]
    mean: Floats32 | None = field(default=None)
    """(beams, samples) expected amplitude without speckle, where it is known."""


def circle_target(
    range_m: float, bearing_rad: float, radius_m: float, margin_m: float, margin_rad: float, *, counts: bool = True
) -> Target:
    """Return the target of a body: the box around its circle, widened by the margins."""
    across = float(np.arcsin(min(1.0, radius_m / max(range_m, 1e-9)))) + margin_rad
    return Target(
        (range_m - radius_m - margin_m, range_m + radius_m + margin_m),
        (bearing_rad - across, bearing_rad + across),
        (range_m, bearing_rad, radius_m),
        counts,
    )
