"""Walls and the like in pieces: what is too large for one circle is cut where it crosses squares fixed in the world.

One circle around a wall reaches as far towards the sonar as the wall does to either side. The pieces stay where they
are as the sonar moves along, so each of them is an object that rests.
"""

import numpy as np

from ods.base.arrays import Image, Ints, Mask
from ods.base.frames.geometry import rotation_matrix
from ods.compiled import native
from ods.messages import Pose
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import RUN, Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.measure.echoes import EchoTable, measure_echoes
from ods.pose.buffer import PoseEstimate

LARGEST_M = 8.0
"""Radius from which on a region is cut: highlights of the bottom, and what moves, are smaller. The echo of a wall rises
as steeply as the wall faces the beams, so that its onset shows nothing."""
SIDE_M = 4.2
"""Of the squares: a piece has a circle of at most 3 m."""


def measure_pieces(
    image: Image, regions: Regions, recorded: Recorded, fan: Fan, head: Pose | PoseEstimate | None
) -> tuple[Regions, EchoTable]:
    """Return regions, large ones in pieces, and their echoes, as `measure_echoes` does.

    head: the sonar's; None: not known, then nothing is cut. Raises NotANumberError.
    """
    echoes = measure_echoes(image, regions, recorded, fan)
    large = echoes["radius_m"] > LARGEST_M
    if head is not None and large.any():
        regions, whole = _cut(regions, large, fan, head)
        echoes, large = measure_echoes(image, regions, recorded, fan), large[whole]
    echoes["onset"][large] = 0.0
    return regions, echoes


def _cut(regions: Regions, large: Mask, fan: Fan, head: Pose | PoseEstimate) -> tuple[Regions, Ints]:
    """Return regions with the large ones, (total,), cut, and which of them each of the new ones is of."""
    room = int((regions.runs["stop"] - regions.runs["first"]).sum())
    runs, whole = np.empty(room, RUN), np.empty(room, np.int64)
    seen_from = np.array(head.position_ned, np.float64), rotation_matrix(np.array(head.attitude, np.float64))
    runs = runs[: native.cut_regions(regions.runs, large, fan.table, *seen_from, SIDE_M, runs, whole)]
    whole = whole[: runs["region"][-1]]
    faint = None if regions.faint is None else regions.faint[whole]
    return regions._replace(runs=runs, total=len(whole), faint=faint), whole
