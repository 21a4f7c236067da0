"""The settings that are assessed: every filter with every detector and every attention, one table each.

Add a row when the pipeline gets a stage. Rows whose stages or parameters the pipeline does not know are left out.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

from msgspec.structs import replace

from ods.pipeline import chain  # noqa: F401  it registers the stages
from ods.pipeline.settings import DEFAULT_STAGES, AttentionSettings, PipelineSettings, StageTable
from ods.pipeline.stage.configured import find_stage
from ods.pipeline.stage.params import StageError, read_params

DEFAULT = "default"
"""Name of the chain that a configuration without stages gets."""

EQUALIZERS: tuple[StageTable, ...] = tuple(stage for stage in DEFAULT_STAGES if stage["use"].startswith("equalize."))
"""Before every filter, those of the default chain."""

FILTERS: Mapping[str, tuple[StageTable, ...]] = {
    "no filter": (),
    "FIR 9": ({"use": "filter.fir", "taps": 9},),
    "FIR 15": ({"use": "filter.fir", "taps": 15, "cutoff": 0.06},),
    "box 5": ({"use": "filter.box", "window": 5},),
    "box 9": ({"use": "filter.box"},),
    "box 15": ({"use": "filter.box", "window": 15},),
    "median 5": ({"use": "filter.median", "window": 5},),
    "median 9": ({"use": "filter.median"},),
    "Wiener 9": ({"use": "filter.wiener"},),
    "Wiener 9, box 9": ({"use": "filter.wiener"}, {"use": "filter.box"}),
    "Gaussian 2.5": ({"use": "filter.gaussian"},),
    "FIR 9 x 3 beams": ({"use": "filter.fir", "taps": 9, "beams": 3},),
    "box 9 x 3 beams": ({"use": "filter.box", "beams": 3},),
    "median 9 x 3 beams": ({"use": "filter.median", "beams": 3},),
    "Wiener 9 x 3 beams": ({"use": "filter.wiener", "beams": 3},),
    "Gaussian 2.5 x 0.7 beams": ({"use": "filter.gaussian", "beam_sigma": 0.7},),
}


@dataclass(frozen=True)
class Detector:
    """A detector and the sweep of its threshold."""

    stage: StageTable
    sweep: tuple[StageTable, ...]
    """Parameters of each step, from few false alarms to many."""


_LEVELS = (30.0, 18.0, 12.0, 9.0, 7.0, 5.5, 4.5, 3.5)
_RATES = (1e-8, 1e-6, 1e-5, 1e-4, 1e-3)
_FEW_RATES = (1e-6, 1e-5, 1e-4)
"""For the order statistic, which takes tens of times as long as the others."""
_CFAR = tuple({"rate": rate} for rate in _RATES)

DETECTORS: Mapping[str, Detector] = {
    "two-level": Detector({"use": "detect.two_level", "min_cells": 4}, tuple({"high": level} for level in _LEVELS)),
    "one-level": Detector({"use": "detect.one_level"}, tuple({"level": level} for level in _LEVELS)),
    "CA-CFAR": Detector({"use": "detect.cfar", "method": "ca"}, _CFAR),
    "GOCA-CFAR": Detector({"use": "detect.cfar", "method": "goca"}, _CFAR),
    "SOCA-CFAR": Detector({"use": "detect.cfar", "method": "soca"}, _CFAR),
    "OS-CFAR": Detector({"use": "detect.cfar", "method": "os"}, tuple({"rate": rate} for rate in _FEW_RATES)),
}

ATTENTION: Mapping[str, AttentionSettings] = {
    "": AttentionSettings(),
    "every 2nd sample": AttentionSettings(subsample=2),
    "4 rings": AttentionSettings(near_m=30.0, every=4),
    "4 rings, every 2nd sample": AttentionSettings(near_m=30.0, every=4, subsample=2),
}
"""What is processed when; the first row is all of each ping."""


@dataclass(frozen=True)
class Setting:
    """One row of the table that `ods assess detect` prints."""

    name: str
    settings: tuple[PipelineSettings, ...]
    """One for each step of the threshold's sweep."""
    filters: tuple[StageTable, ...]
    """Equalizers and filters, without the detector."""


def all_settings() -> list[Setting]:
    """Return every combination whose stages are known, the default chain first."""
    steps = DETECTORS["two-level"].sweep if DEFAULT_STAGES[-1]["use"] == "detect.two_level" else ({},)
    default = setting_of(DEFAULT, DEFAULT_STAGES[:-1], Detector(DEFAULT_STAGES[-1], steps), AttentionSettings())
    return [default, *_combinations()]


def _combinations() -> Iterator[Setting]:
    for (filter_name, filters), (name, detector), (attention_name, attention) in product(
        FILTERS.items(), DETECTORS.items(), ATTENTION.items()
    ):
        stages = (*EQUALIZERS, *filters, {**detector.stage, **detector.sweep[0]})
        if all(map(_is_known, stages)):
            label = f"{filter_name}, {name}" + (f", {attention_name}" if attention_name else "")
            yield setting_of(label, (*EQUALIZERS, *filters), detector, attention)


def _is_known(stage: StageTable) -> bool:
    try:
        read_params(find_stage(stage["use"]).params, stage)
    except StageError:
        return False
    return True


def setting_of(
    name: str,
    filters: tuple[StageTable, ...],
    detector: Detector,
    attention: AttentionSettings,
    others: PipelineSettings = PipelineSettings(),  # noqa: B008  it is immutable
) -> Setting:
    """Return a row of the table; `others`: all that is not swept."""
    chains = tuple(
        replace(others, stage=(*filters, {**detector.stage, **step}), attention=attention) for step in detector.sweep
    )
    return Setting(name, chains, filters)
