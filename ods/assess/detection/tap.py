"""Filtered image of a ping, taken at the input of the detector."""

from collections.abc import Sequence

import numpy as np

from ods.base.arrays import Image
from ods.base.settings import Settings
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import RUN, Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.settings import PipelineSettings, StageTable
from ods.pipeline.stage.registry import detect_stage
from ods.pipeline.stage.step import PreparedDetector

_STAGE = "assess.tap"
_seen: list[Image] = []


class TapParams(Settings, frozen=True):
    """assess.tap has none."""


@detect_stage(_STAGE, TapParams)
def tap(params: TapParams, fan: Fan) -> PreparedDetector:
    """Keep the image and detect nothing."""

    def find(image: Image, recorded: Recorded) -> Regions:
        _seen.append(np.array(image))
        return Regions(np.empty(0, RUN), 0, 1.0)

    return PreparedDetector(find)


def filtered(stages: Sequence[StageTable], ping: Ping) -> Image:
    """Return what image stages make of a ping of one plane: (beams, samples) amplitude, from range 0 on.

    Raises StageError.
    """
    _seen.clear()
    Chain(PipelineSettings(stage=(*stages, {"use": _STAGE}), min_range_m=0.0)).process(ping)
    return _seen[-1]
