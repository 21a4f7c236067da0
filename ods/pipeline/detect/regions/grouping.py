"""Grouping of the cells above a level into regions, and selection of the regions."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Image, Mask
from ods.compiled import native
from ods.pipeline.detect.background.rise import NO_RISE, Rise, levelled
from ods.pipeline.detect.regions.region_growing import GrowingRule, find_regions, room_for_runs
from ods.pipeline.detect.regions.split import split_regions
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import Judged, Regions, Runs, chosen_runs
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.stage.params import GroupParams, NotANumberError


class DetectionLevels(NamedTuple):
    """Levels of one image: cells above `low` are an echo when one of them is above `high`; both rise as `rise` says."""

    low: float
    high: float
    background: float
    rise: Rise = NO_RISE


class Grouping:
    """Puts cells together to regions, and keeps those that `GroupParams` ask for."""

    def __init__(self, params: GroupParams, fan: Fan) -> None:
        self._params = params
        self._fan = fan
        self._runs = room_for_runs(fan.shape)
        self._visited = np.zeros(fan.shape, np.bool_)
        self._wanted = _size_test(params, fan)

    def nothing(self, image: Image) -> Regions:
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
            strong = self._strong(image, recorded, Regions(runs, count, background), levels)
            runs, count = chosen_runs(runs, strong)
        return Regions(runs, count, background, Judged(lambda: levelled(image, rise), low, high))

    def _strong(self, image: Image, recorded: Recorded, regions: Regions, levels: DetectionLevels) -> Mask:
        """Return (total,) bool: regions strong enough at the border, and by their recorded samples.

        A filter mirrors the image at its border, so half of its samples count twice, and its noise has up to twice the
        power that it has elsewhere; equalizers, too, know only one side. They also lift what is nearly silent, so an
        echo has a sample among the strongest recorded ones.
        """
        params, (_, high, background, rise) = self._params, levels
        strong, found = np.ones(regions.total, np.bool_), np.empty(regions.total, np.bool_)
        if params.border > 1.0:
            raised = background + params.border * (high - background)
            native.strong_at_border(image, regions.runs, high, raised, rise, found)
            strong &= found
        if params.strongest < 1.0:
            native.strong_as_recorded(recorded, regions.runs, level_of_strongest(recorded, params.strongest), found)
            strong &= found
        return strong


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


def level_of_strongest(recorded: Recorded, share: float) -> float:
    """Return the level that this share of the recorded samples that hold data reaches; 0 where none does.

    Looked at are some of them, evenly spread, in steps that never fall in with the rows.
    """
    level: float = native.level_of_strongest(recorded, share)
    return level
