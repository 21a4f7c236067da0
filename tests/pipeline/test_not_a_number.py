"""A stage that makes NaN or infinity is an error of that ping, which names the stage; the next ping begins afresh."""

import numpy as np
import pytest

from ods.base.arrays import Image
from ods.base.settings import Settings
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.image.regions import RUN, Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.params import StageError
from ods.pipeline.stage.registry import detect_stage, gain_stage, image_stage
from ods.pipeline.stage.step import GainStep, ImageStep, PreparedDetector
from tests.pipeline.pings import body_echo, fan_bearings, make_ping


class Illness:
    """What `ill` writes where; 0: nothing."""

    value = 0.0
    place: tuple[int | slice, int | slice] = (30, 900)


class NoParams(Settings, frozen=True):
    """It has none."""


@image_stage("test.ill", NoParams)
def ill(_params: NoParams, _fan: Fan) -> ImageStep:
    def step(source: Image, out: Image) -> None:
        out[:] = source
        if Illness.value:
            out[Illness.place] = Illness.value

    return step


@gain_stage("test.ill_gain", NoParams)
def ill_gain(_params: NoParams, fan: Fan) -> GainStep:
    gain = np.ones((1, fan.samples), np.float32)

    def step(image: GainedImage) -> GainedImage:
        gain[0, 500] = Illness.value or 1.0
        return image._replace(gain=gain, plain=False)

    return step


@detect_stage("test.blind", NoParams)
def blind(_params: NoParams, _fan: Fan) -> PreparedDetector:
    def find(_image: Image, _recorded: Recorded) -> Regions:
        return Regions(np.empty(0, RUN), 0, 1.0)

    return PreparedDetector(find)


def ping(seed: int) -> Ping:
    intensity = 1.0 + 60.0 * body_echo("half", 1.5, 50.0, 0.1, fan_bearings(60), 2000)
    counts = 30.0 * np.sqrt(intensity * np.random.default_rng(seed).exponential(size=intensity.shape))
    return make_ping(np.minimum(counts, 255.0).astype(np.uint8), t_ns=seed * 10**8)


def chain_with(*middle: str, last: str = "detect.two_level") -> Chain:
    names = ("equalize.mean_range", *middle, last)
    return Chain(PipelineSettings(stage=tuple({"use": name} for name in names)))


@pytest.fixture(autouse=True)
def _healed() -> None:
    Illness.value, Illness.place = 0.0, (30, 900)


@pytest.mark.parametrize("value", [np.nan, np.inf])
@pytest.mark.parametrize(
    ("chain", "culprit"),
    [
        (("test.ill", "filter.fir"), r"stage\[1\] \(test.ill\)"),
        (("filter.fir", "test.ill"), r"stage\[2\] \(test.ill\)"),
        (("filter.fir", "test.ill", "filter.ping_iir", "equalize.background"), r"stage\[2\] \(test.ill\)"),
        (("test.ill_gain", "filter.fir"), r"stage\[1\] \(test.ill_gain\)"),
        (("test.ill_gain",), r"stage\[1\] \(test.ill_gain\)"),
    ],
)
@pytest.mark.parametrize("last", ["detect.two_level", "detect.cfar"])
def test_stage_is_named_and_the_next_ping_is_good(
    chain: tuple[str, ...], culprit: str, value: float, last: str
) -> None:
    works = Chain(PipelineSettings(stage=tuple(
        {"use": name} for name in ("equalize.mean_range", *chain, last))), learnt_cells=500_000)  # fmt: skip
    assert works.process(ping(1)).detections
    Illness.value = value
    for seed in (2, 3):
        with pytest.raises(StageError, match=culprit + ": its image has values that are not finite"):
            works.process(ping(seed))
    Illness.value = 0.0
    assert works.process(ping(4)).detections


@pytest.mark.parametrize("place", [(0, 0), (59, 1999), (30, 63), (slice(None), slice(None)), (slice(None), 7)])
def test_one_cell_anywhere_is_enough(place: tuple[int | slice, int | slice]) -> None:
    works = chain_with("filter.fir", "test.ill")
    Illness.value, Illness.place = np.nan, place
    with pytest.raises(StageError, match=r"test\.ill"):
        works.process(ping(1))


def test_plug_in_that_detects_need_not_look_for_it() -> None:
    works = chain_with("test.ill", last="test.blind")
    assert works.process(ping(1)).detections == []
    Illness.value = np.nan
    with pytest.raises(StageError, match=r"test\.ill"):
        works.process(ping(2))
