"""A ping as it came, as an image for the page: decibels over its median, with what the pipeline found in it."""

import numpy as np

from ods.base.arrays import AnyArray
from ods.messages import Detections, Ping, frame_of, seen_from_above
from ods.plots.polar import decibels
from ods.workbench.model.state import View
from ods.workbench.web.frames import Circle, Frame, cells_of

COUNTS = {"u1": 256, "u2": 65536}
"""Values that a sample can have, where they are few: what each looks like is in a table."""


def frame_of_ping(ping: Ping, found: Detections | None, view: View) -> Frame:
    """Return a ping's image, of its first plane; found: of the same ping. Raises ValueError for a bad buffer."""
    ping = seen_from_above(ping)
    beams = ping.beams // ping.planes
    samples = frame_of(ping)[:beams]
    scale = view.lowest_db, view.highest_db
    if ping.dtype in COUNTS:
        values = decibels(np.arange(COUNTS[ping.dtype], dtype=np.float32), ping)
        cells = cells_of(values - values[_median_of_counts(samples)], scale)[samples]
    else:
        levels = decibels(samples, ping)
        cells = cells_of(levels - np.median(levels), scale)
    circles = () if found is None else tuple(
        Circle(each.range_m, each.bearing_rad, each.radius_m) for each in found.detections
    )  # fmt: skip
    caption = f"ping {ping.ping_number}"
    if found is not None:
        caption += f", {len(circles)} detections" + ("" if found.usable else ", a drop-out")
    return Frame(cells, np.array(ping.bearing_rad[:beams]), ping.range0_m, ping.dr_m, scale, circles, caption=caption)


def _median_of_counts(samples: AnyArray) -> int:
    """Return the lower median of unsigned samples."""
    below = np.cumsum(np.bincount(samples.ravel()))
    return int(np.searchsorted(below, (int(below[-1]) + 1) // 2))
