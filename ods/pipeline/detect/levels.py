"""Detection by levels, `two_level` and `one_level` [SSIE, Image processing, stage 3]."""

from collections.abc import Iterable
from statistics import median

import numpy as np

from ods.base.arrays import Image
from ods.compiled import native
from ods.pipeline.detect.background.crests import LocalThreshold
from ods.pipeline.detect.background.noise import background_and_noise
from ods.pipeline.detect.background.rise import ThresholdRise
from ods.pipeline.detect.background.tail import TailQuantile
from ods.pipeline.detect.regions.grouping import DetectionLevels, Grouping
from ods.pipeline.fronts.judge import can_be_judged
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.stage.params import OneLevelParams, TwoLevelParams
from ods.pipeline.stage.registry import detect_stage
from ods.pipeline.stage.step import PreparedDetector

_ROUGH, _ROUGH_QUARTER = 1.45, 3
"""A bed is rough where crests reach more than so many times as high as those of speckle in a quarter of the image: over
even beds, and in water, they do in less."""
_LEAST_NOISE = 0.02
"""Of the background: keeps the rounding of a noiseless image from becoming echoes."""


@detect_stage("detect.two_level", TwoLevelParams)
def two_level(params: TwoLevelParams, fan: Fan) -> PreparedDetector:
    """Find connected regions above the low level in which at least one cell is above the high level."""
    fronts = params.fronts and can_be_judged(fan)
    return level_detector(params, fan, (params.low, params.high), min(params.faint, params.follow), fronts=fronts)


@detect_stage("detect.one_level", OneLevelParams)
def one_level(params: OneLevelParams, fan: Fan) -> PreparedDetector:
    """Find connected regions above one level; for comparison: objects fall to pieces or speckle joins in."""
    return level_detector(params, fan, (params.level, params.level), params.follow)


def level_detector(
    params: TwoLevelParams | OneLevelParams,
    fan: Fan,
    levels: tuple[float, float],
    faint: float,
    *,
    fronts: bool = False,
) -> PreparedDetector:
    """Return a detector that finds the regions between two levels, given in the units of `params.levels`.

    faint: how far levels rise with the background's crests for what is found at all; what does not reach the high one
    where it rises by `params.follow` is faint. fronts: faint echoes are judged by how they set in where the bed is
    rough, so that levels need not rise for them there.
    """
    low, high = levels
    crests, tail = LocalThreshold(fan.shape), TailQuantile(params.rate)
    group = Grouping(params, fan)
    follow = params.follow if params.levels == "noise" else 0.0
    low_power = 0.0 if fronts and faint < follow else faint

    def find(image: Image, recorded: Recorded) -> Regions:
        background, noise = background_and_noise(image)
        if background <= 0.0:
            return group.no_regions(image)
        below, above = levels_between(params.levels, low, high, background, noise)
        if params.levels == "false_alarm":
            above = max(tail.level(image, background, noise), background * (1.0 + _LEAST_NOISE))
            below = above if low == high else min(below, above)
        if follow:
            return following(image, recorded, (below, above, background), noise)
        found = group.regions(image, recorded, DetectionLevels(below, above, background))
        return found._replace(heard_from=above / background)

    def following(image: Image, recorded: Recorded, wanted: tuple[float, float, float], noise: float) -> Regions:
        """Return the regions where levels follow the crests; wanted: the low and the high one, and the background."""
        below, above, background = wanted
        factors = crests.factors(image, (background, max(noise, _LEAST_NOISE * background)), high)
        ordered = sorted(factors.ravel().tolist())
        rough = fronts and ordered[_ROUGH_QUARTER * len(ordered) // 4] > _ROUGH
        rise = ThresholdRise(background, factors, low_power, low_power if rough else faint, *crests.region)
        runs, total, _, judged, *_ = group.regions(image, recorded, DetectionLevels(below, above, background, rise))
        heard_from = 1.0 + (above / background - 1.0) * median(ordered) ** faint
        if faint >= follow:
            return Regions(runs, total, background, judged, None, heard_from, rough)
        strong = np.empty(total, np.bool_)
        native.reaching(image, runs, above, rise._replace(high_power=follow), strong)
        return Regions(runs, total, background, judged, ~strong, heard_from, rough)

    def learn_one_look(kinds: Iterable[Iterable[Image]]) -> None:
        crests.learn(next(iter(kinds)))  # which is the first kind

    learn = learn_one_look if follow else tail.learn if params.levels == "false_alarm" else None
    return PreparedDetector(find, learn, refuses_nan=True, learnt=crests.of_speckle if follow else None)


def levels_between(unit: str, low: float, high: float, background: float, noise: float) -> tuple[float, float]:
    """Return the low and the high level for an image of this background and noise."""
    if unit == "absolute":
        return low, high
    if unit == "background":
        return low * background, high * background
    spread = max(noise, _LEAST_NOISE * background)
    return background + low * spread, background + high * spread
