"""Detection by levels [SSIE, Image processing, stage 3]: which cells are echoes, and which of them belong together."""

from collections.abc import Callable

import numpy as np

from ods.base.arrays import Image, Ints
from ods.base.kernel import kernel
from ods.pipeline.detect.edge_of_image import drop_weak_at_border
from ods.pipeline.detect.noise import Learner, NoiseMeter
from ods.pipeline.detect.region_growing import find_regions
from ods.pipeline.detect.split import split_regions
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import Regions, Runs
from ods.pipeline.stage.params import GroupParams, OneLevelParams, TwoLevelParams
from ods.pipeline.stage.registry import DetectStep, detect_stage

_LEAST_NOISE = 0.02
"""Of the background: keeps the rounding of a noiseless image from becoming echoes."""


@detect_stage("detect.two_level", TwoLevelParams)
def two_level(params: TwoLevelParams, fan: Fan) -> DetectStep:
    """Find connected regions above the low level in which at least one cell is above the high level."""
    return level_step(params, fan, params.low, params.high)


@detect_stage("detect.one_level", OneLevelParams)
def one_level(params: OneLevelParams, fan: Fan) -> DetectStep:
    """Find connected regions above one level; for comparison: objects fall to pieces or speckle joins in."""
    return level_step(params, fan, params.level, params.level)


def level_step(params: TwoLevelParams | OneLevelParams, fan: Fan, low: float, high: float) -> DetectStep:
    """Return a step that finds the regions between two levels, given in the units of `params.levels`."""
    meter = NoiseMeter()
    group = Grouping(params, fan)

    def step(image: Image) -> Regions:
        background, noise = meter.background_and_noise(image)
        if background <= 0.0:
            return group.nothing()
        below, above = levels(params.levels, low, high, background, noise)
        if params.levels == "false_alarm":
            above = max(meter.level_of_rate(image, params.rate), background * (1.0 + _LEAST_NOISE))
            below = above if low == high else min(below, above)
        return group.regions(image, below, above, background)

    return Learner(step, meter.learn) if params.levels == "false_alarm" else step


def levels(unit: str, low: float, high: float, background: float, noise: float) -> tuple[float, float]:
    """Return the low and the high level for an image of this background and noise."""
    if unit == "absolute":
        return low, high
    if unit == "background":
        return low * background, high * background
    spread = max(noise, _LEAST_NOISE * background)
    return background + low * spread, background + high * spread


class Grouping:
    """Puts cells together to regions, and sorts out those of the wrong size."""

    def __init__(self, params: GroupParams, fan: Fan) -> None:
        beams, samples = fan.shape
        self._params = params
        self._fan = fan
        self._runs = np.empty((beams * (samples // 2 + 1), 4), np.int32)  # no image has more; untouched, they are free
        self._visited = np.zeros(fan.shape, np.bool_)
        self._wanted = _size_test(params, fan)

    def nothing(self) -> Regions:
        """Return the regions of an image that shows nothing."""
        return Regions(self._runs[:0], 0, 1.0)

    def regions(self, image: Image, low: float, high: float, background: float) -> Regions:
        """Return the regions of image (beams, samples) above `low` that have a cell above `high`."""
        params = self._params
        used, count = find_regions(
            image, np.float32(low), np.float32(high), int(params.connectivity == 8), params.min_cells,
            params.max_cells or image.size, self._runs, self._visited,
        )  # fmt: skip
        runs = self._runs[:used]
        if params.split_db > 0.0 and count:
            runs, count = split_regions(image, runs, params.split_db, low, params.min_cells, self._fan)
        if self._wanted is not None and count:
            runs, count = chosen(runs, self._wanted)
        if params.border > 1.0 and count:
            count = drop_weak_at_border(image, runs, count, high, background + params.border * (high - background))
        return Regions(sorted_runs(runs), count, background)


def _size_test(params: GroupParams, fan: Fan) -> Callable[[Runs], bool] | None:
    """Return what tells whether a region is as large as wanted; None when any is."""
    if not params.min_extent_m and not params.max_extent_m:
        return None

    def wanted(runs: Runs) -> bool:
        first, stop = int(runs[:, 1].min()), int(runs[:, 2].max())
        across = fan.borders_rad[runs[:, 0].max() + 1] - fan.borders_rad[runs[:, 0].min()]
        middle = 0.5 * float(fan.range_m[first] + fan.range_m[stop - 1])
        extent = max((stop - first) * fan.dr_m, middle * float(across))
        return params.min_extent_m <= extent and (not params.max_extent_m or extent <= params.max_extent_m)

    return wanted


def chosen(runs: Runs, wanted: Callable[[Runs], bool]) -> tuple[Runs, int]:
    """Return the runs of the regions that are wanted, renumbered, and the number of regions."""
    kept = [part for part in (runs[runs[:, 3] == k] for k in range(1, int(runs[:, 3].max()) + 1)) if wanted(part)]
    for number, part in enumerate(kept, 1):
        part[:, 3] = number
    return (np.vstack(kept) if kept else runs[:0]), len(kept)


@kernel
def sorted_runs(runs: Runs) -> Runs:
    """Return the runs of numbered regions, by region, beam and column."""
    kept = runs[runs[:, 3] > 0]
    order = np.argsort(_sort_key(kept))
    return kept[order]


@kernel
def _sort_key(runs: Runs) -> Ints:
    key = np.empty(runs.shape[0], np.int64)
    for i in range(key.size):
        key[i] = (np.int64(runs[i, 3]) << 32) + (np.int64(runs[i, 0]) << 17) + runs[i, 1]  # 4096 beams, 65536 samples
    return key
