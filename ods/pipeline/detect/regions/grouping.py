"""Grouping of the cells above a level into regions, and selection of the regions."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Image, Mask
from ods.compiled import native
from ods.pipeline.detect.background.rise import ThresholdRise, levelled
from ods.pipeline.detect.regions.split import split_regions
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import RUN, Regions, Runs, ThresholdedImage
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.stage.params import GroupParams, NotANumberError


class DetectionLevels(NamedTuple):
    """Levels of one image: cells above `low` are an echo when one of them is above `high`; both rise as `rise` says."""

    low: float
    high: float
    background: float
    rise: ThresholdRise = ThresholdRise.none()


class GrowingRule(NamedTuple):
    """Which cells make a region; levels are compared as float32."""

    low: float
    """Cells above it belong to a region,"""
    high: float
    """which has at least one above this."""
    corner: int
    """1 when cells that touch by a corner are connected, 0 when they have to share a side."""
    smallest: int
    largest: int
    """Cells of a region."""
    rise: ThresholdRise = ThresholdRise.none()
    """Of both levels."""


def room_for_runs(shape: tuple[int, int]) -> Runs:
    """Return room for the most runs an image of (beams, samples) can have; what is not written costs no memory."""
    beams, samples = shape
    return np.empty(beams * (samples // 2 + 1), RUN)


def find_regions(image: Image, rule: GrowingRule, work: Runs, visited: Mask) -> tuple[Runs, int]:
    """Return the runs of all regions of image (beams, samples), sorted, and the number of regions; they lie in `work`.

    work: as `room_for_runs` makes it; visited, (beams, samples), must be all False and is so again at the end.
    Raises NotANumberError where a cell is not finite.
    """
    count = native.find_regions(image, rule, work, visited)
    if count < 0:
        raise NotANumberError
    runs = work[:count]
    return runs, int(runs["region"][-1]) if count else 0


class Grouping:
    """Puts cells together to regions, and keeps those that `GroupParams` ask for."""

    def __init__(self, params: GroupParams, fan: Fan) -> None:
        self._params = params
        self._fan = fan
        self._runs = room_for_runs(fan.shape)
        self._visited = np.zeros(fan.shape, np.bool_)
        self._wanted = _size_test(params, fan)

    def no_regions(self, image: Image) -> Regions:
        """Return the regions of image (beams, samples), which shows nothing. Raises NotANumberError."""
        if not np.isfinite(image).all():
            raise NotANumberError
        return Regions(self._runs[:0], 0, 1.0)

    def regions(self, image: Image, recorded: Recorded, levels: DetectionLevels) -> Regions:
        """Return the regions of image (beams, samples) between the levels. Raises NotANumberError."""
        params, (low, high, background, rise) = self._params, levels
        corner, largest = int(params.connectivity == 8), params.max_cells or image.size
        rule = GrowingRule(low, high, corner, params.min_cells, largest, rise)
        runs, count = find_regions(image, rule, self._runs, self._visited)
        if params.split_db > 0.0 and count:
            runs, count = split_regions(levelled(image, rise), runs, params.split_db, low, params.min_cells, self._fan)
        if self._wanted is not None and count:
            runs, count = of_size(runs, self._wanted)
        if count and (params.border > 1.0 or params.strongest < 1.0):
            runs, count = self._strong(image, recorded, (runs, count), levels)
        return Regions(runs, count, background, ThresholdedImage(lambda: levelled(image, rise), low, high))

    def _strong(
        self, image: Image, recorded: Recorded, found: tuple[Runs, int], levels: DetectionLevels
    ) -> tuple[Runs, int]:
        """Return the runs of regions that are strong enough at the border, and by their recorded samples.

        A filter mirrors the image at its border, so half of its samples count twice, and its noise has up to twice the
        power that it has elsewhere; equalizers, too, know only one side. They also lift what is nearly silent, so an
        echo has a sample among the strongest recorded ones.
        """
        params, (_, high, background, rise) = self._params, levels
        raised = background + params.border * (high - background)
        least = native.level_of_strongest(recorded, params.strongest) if params.strongest < 1.0 else -np.inf
        runs, total = found
        out = np.empty_like(runs)
        chosen = out[: native.choose_strong(image, runs, total, high, raised, least, rise, recorded, out)]
        return chosen, int(chosen["region"][-1]) if chosen.size else 0


def _size_test(params: GroupParams, fan: Fan) -> Callable[[Runs], bool] | None:
    """Return the test of whether a region is as large as wanted; None when any is."""
    if not params.min_extent_m and not params.max_extent_m:
        return None

    def wanted(runs: Runs) -> bool:
        first, stop = int(runs["first"].min()), int(runs["stop"].max())
        across = fan.borders_rad[runs["beam"].max() + 1] - fan.borders_rad[runs["beam"].min()]
        middle = 0.5 * float(fan.range_m[first] + fan.range_m[stop - 1])
        extent = max((stop - first) * fan.dr_m, middle * float(across))
        return params.min_extent_m <= extent and (not params.max_extent_m or extent <= params.max_extent_m)

    return wanted


def of_size(runs: Runs, wanted: Callable[[Runs], bool]) -> tuple[Runs, int]:
    """Return the runs of the regions that are wanted, renumbered, and the number of regions."""
    region = runs["region"]
    kept = [part for part in (runs[region == k] for k in range(1, int(region.max()) + 1)) if wanted(part)]
    for number, part in enumerate(kept, 1):
        part["region"] = number
    return (np.concatenate(kept) if kept else runs[:0]), len(kept)
