"""Levels of a detector in the image, and the settings that they stand for: what dragging a level changes."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from ods.pipeline.stage.params import BUILT_IN, OneLevelParams, StageError, TwoLevelParams, read_params
from ods.workbench.engine.ping.look import Look

DIGITS = 3
"""Significant digits that a dragged level gives its setting."""
LEAST = 1e-3


class Threshold(NamedTuple):
    """A level that the detector compared its image with."""

    name: str
    """"high", "low" or "level"; the setting's, where one stands for it."""
    level_db: float
    """Over the image's median."""
    draggable: bool


def thresholds(look: Look, stage: Mapping[str, Any]) -> list[Threshold]:
    """Return the levels of the last look, by the stage's table `stage`; one where high and low are the same."""
    if look.levels is None or look.levels_db is None:
        return []
    low, high = look.levels_db
    scale = _scale(look, stage)
    if stage["use"] == "detect.one_level":
        return [Threshold("level", high, scale is not None)]
    fixed = stage.get("levels") == "false_alarm"
    return [
        Threshold("low", low, scale is not None and not fixed),
        Threshold("high", high, scale is not None and not fixed),
    ]


def setting_at(look: Look, stage: Mapping[str, Any], level_db: float) -> float | None:
    """Return the value of the setting whose level lies at `level_db`; None: no setting tells this level."""
    scale = _scale(look, stage)
    if scale is None:
        return None
    background, noise = scale
    value = max((look.amplitude_of(level_db) - background) / noise, LEAST)
    return float(f"{value:.{DIGITS}g}")


def _scale(look: Look, stage: Mapping[str, Any]) -> tuple[float, float] | None:
    """Return level at value 0 and the rise of the level with the value, from where the levels lie now."""
    if stage["use"] not in ("detect.two_level", "detect.one_level") or look.levels is None:
        return None
    try:
        params = read_params(BUILT_IN[stage["use"]], stage)
    except StageError:
        return None
    assert isinstance(params, TwoLevelParams | OneLevelParams)
    low, high = (params.low, params.high) if isinstance(params, TwoLevelParams) else (params.level, params.level)
    match params.levels:
        case "absolute":
            return 0.0, 1.0
        case "background":
            return 0.0, look.levels[1] / high
        case "false_alarm":
            return None
    if math.isclose(low, high):  # the background is the median of the image
        return look.unit, (look.levels[1] - look.unit) / high
    noise = (look.levels[1] - look.levels[0]) / (high - low)
    return look.levels[0] - low * noise, noise
