"""Cell-averaging and order-statistic CFAR along the beam, with the two levels measured instead of assumed."""

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Image
from ods.compiled import native
from ods.pipeline.detect.background.noise import background_and_noise
from ods.pipeline.detect.background.tail import TailQuantile
from ods.pipeline.detect.regions.grouping import DetectionLevels, Grouping
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.stage.params import CfarParams
from ods.pipeline.stage.registry import detect_stage
from ods.pipeline.stage.step import PreparedDetector

_METHODS = ("ca", "goca", "soca", "os")


@detect_stage("detect.cfar", CfarParams)
def cfar(params: CfarParams, fan: Fan) -> PreparedDetector:
    """Find regions in the image divided by the level of each cell's surroundings.

    CA: M. Finn, R. S. Johnson, 1968; GOCA: V. G. Hansen, 1973; SOCA: G. V. Trunk, 1978; OS: H. Rohling, 1983.
    """
    tail = TailQuantile(params.rate)
    group = Grouping(params, fan)
    ratio = np.empty(fan.shape, np.float32)
    around = CfarWindow(_METHODS.index(params.method), params.guard, params.train, params.rank)

    def divided(image: Image, middle: float) -> Image:
        divide_by_surroundings(image, around, middle, ratio)
        return ratio

    def ratios(images: Iterable[Image]) -> Iterator[Image]:
        some = islice(images, 0, None, 4) if params.method == "os" else images  # ordering takes ten times as long
        return (divided(image, background_and_noise(image)[0]) for image in some)

    def learn(kinds: Iterable[Iterable[Image]]) -> None:
        tail.learn(ratios(images) for images in kinds)

    def find(image: Image, recorded: Recorded) -> Regions:
        middle, _ = background_and_noise(image)
        if middle <= 0.0:
            return group.no_regions(image)
        divided(image, middle)
        background, noise = background_and_noise(ratio)
        if background <= 0.0:
            return group.no_regions(ratio)
        high = tail.level(ratio, background, noise)
        low = min(background + params.low * max(noise, 0.02 * background), high)
        found = group.regions(ratio, recorded, DetectionLevels(low, high, background))
        return found._replace(background=middle)

    return PreparedDetector(find, learn, refuses_nan=True)


class CfarWindow(NamedTuple):
    """The cells that give the level around a cell, and how they are combined."""

    method: int
    """Place in `_METHODS`, and in cfar.c's."""
    guard: int
    """Samples on each side of a cell that do not count,"""
    train: int
    """and beyond them, that do."""
    rank: float
    """os: quantile of the surroundings that is taken."""


def divide_by_surroundings(image: Image, around: CfarWindow, middle: float, out: Image) -> None:
    """Fill out with image (beams, samples) over the level of each cell's surroundings, at least 1/20 of `middle`.

    Cells of 0 hold no data and do not count; where there are no others around, the level is `middle`.
    """
    native.divide_by_surroundings(image, around, middle, out)
