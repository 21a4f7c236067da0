"""Suppression of what is smaller than an object, by grey opening [SSIE, Image processing, stage 2]."""

import numpy as np

from ods.base.arrays import Image, Ints
from ods.compiled import native
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.params import MinObjectParams
from ods.pipeline.stage.registry import image_stage
from ods.pipeline.stage.step import ImageStep


@image_stage("filter.min_object", MinObjectParams)
def min_object(params: MinObjectParams, fan: Fan) -> ImageStep:
    """Lower all crests narrower than `size_m`, in range or across, to the level around; larger ones stay as they are.

    The minimum over a window of that size, then the maximum over it. Put it behind a filter that takes out the speckle:
    a dark speckle in an object counts as its end.
    """
    half = max(0, round(0.5 * (params.size_m / fan.dr_m - 1.0)))
    stops = reaches(params.size_m, fan)
    work = np.empty(fan.shape, np.float32)

    def step(source: Image, out: Image) -> None:
        native.open_image(source, half, stops, work, out)

    return step


def reaches(size_m: float, fan: Fan) -> Ints:
    """Return, for k = 1, 2, ..., the column up to which a window of size_m reaches k beams to either side."""
    spacing = float(np.diff(fan.borders_rad).mean())
    distance = np.maximum(fan.range_m, fan.dr_m)
    reach = np.floor(0.5 * (size_m / (distance * spacing) - 1.0))
    stops = [int(np.count_nonzero(reach >= k)) for k in range(1, len(fan.bearing_rad))]
    return np.array([stop for stop in stops if stop], np.int64)
