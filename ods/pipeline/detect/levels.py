"""Detection by levels, `two_level` and `one_level` [SSIE, Image processing, stage 3]."""

from collections.abc import Iterable

from ods.base.arrays import Image
from ods.pipeline.detect.crests import CrestMeter
from ods.pipeline.detect.grouping import DetectionLevels, Grouping
from ods.pipeline.detect.noise import NoiseMeter
from ods.pipeline.detect.tail import TailMeter
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.recorded import Recorded
from ods.pipeline.image.regions import Regions
from ods.pipeline.stage.params import OneLevelParams, TwoLevelParams
from ods.pipeline.stage.registry import detect_stage
from ods.pipeline.stage.step import PreparedDetector

_LEAST_NOISE = 0.02
"""Of the background: keeps the rounding of a noiseless image from becoming echoes."""


@detect_stage("detect.two_level", TwoLevelParams)
def two_level(params: TwoLevelParams, fan: Fan) -> PreparedDetector:
    """Find connected regions above the low level in which at least one cell is above the high level."""
    return level_detector(params, fan, params.low, params.high)


@detect_stage("detect.one_level", OneLevelParams)
def one_level(params: OneLevelParams, fan: Fan) -> PreparedDetector:
    """Find connected regions above one level; for comparison: objects fall to pieces or speckle joins in."""
    return level_detector(params, fan, params.level, params.level)


def level_detector(params: TwoLevelParams | OneLevelParams, fan: Fan, low: float, high: float) -> PreparedDetector:
    """Return a detector that finds the regions between two levels, given in the units of `params.levels`."""
    meter, crests, tail = NoiseMeter(), CrestMeter(fan.shape), TailMeter(params.rate)
    group = Grouping(params, fan)
    follow = params.follow if params.levels == "noise" else 0.0

    def find(image: Image, recorded: Recorded) -> Regions:
        background, noise = meter.background_and_noise(image)
        if background <= 0.0:
            return group.nothing(image)
        measured = background, max(noise, _LEAST_NOISE * background)
        judged = crests.levelled(image, measured, high, follow) if follow else image
        below, above = levels_between(params.levels, low, high, background, noise)
        if params.levels == "false_alarm":
            above = max(tail.level(image, background, noise), background * (1.0 + _LEAST_NOISE))
            below = above if low == high else min(below, above)
        return group.regions(judged, recorded, DetectionLevels(below, above, background))

    def learn_one_look(kinds: Iterable[Iterable[Image]]) -> None:
        crests.learn(next(iter(kinds)))  # which is the first kind

    learn = learn_one_look if follow else tail.learn if params.levels == "false_alarm" else None
    return PreparedDetector(find, learn, refuses_nan=True)


def levels_between(unit: str, low: float, high: float, background: float, noise: float) -> tuple[float, float]:
    """Return the low and the high level for an image of this background and noise."""
    if unit == "absolute":
        return low, high
    if unit == "background":
        return low * background, high * background
    spread = max(noise, _LEAST_NOISE * background)
    return background + low * spread, background + high * spread
