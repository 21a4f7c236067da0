"""The chain at hand among others on speed against accuracy, and what one setting does to both. Runs in the background.

The images, the others and the measures are those of `ods assess detect`, of which this is a small, quick part.
"""

from collections.abc import Callable, Sequence
from functools import cache, reduce
from typing import Any, NamedTuple

import msgspec
import numpy as np

from ods.assess.detection.chains import ATTENTION, DEFAULT, DETECTORS, EQUALIZERS, FILTERS, Setting, setting_of
from ods.assess.detection.measure import accuracy_of, milliseconds, score_of
from ods.assess.detection.own import configured
from ods.assess.images.labelled import LabelledImage
from ods.assess.images.sea import SEA_SONAR, sea_images
from ods.base.files.shipped import shipped_file
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.configured import configured_stages
from ods.sim_sonar.sonar.model import load_sonar
from ods.workbench.model.actions import SetSetting
from ods.workbench.model.apply import apply
from ods.workbench.model.chain.numbers import written
from ods.workbench.model.chain.numbers_first import with_numbers_first
from ods.workbench.model.paths import PathError
from ods.workbench.model.state import State, Tuning

IMAGES, IMAGES_SEED = 16, 4
"""The first of those of `ods assess detect`."""
FALSE_ALARMS = 1.0
"""An image, at which chains are compared."""
ROUNDS = 5
OTHERS = ("no filter", "FIR 9", "FIR 15", "box 5", "median 5", "Wiener 9", "Gaussian 2.5", "FIR 9 x 3 beams")
"""Filters that are compared, with the two-level detector."""

Tell = Callable[[float], bool]
"""Is told the share that is done; what it returns says whether to go on."""


class GivenUpError(Exception):
    """Something newer was asked for."""


class Point(NamedTuple):
    """A chain on the chart."""

    name: str
    ms: float
    """Median time of an image."""
    found: float
    """Share of the objects found at FALSE_ALARMS an image."""
    interval: tuple[float, float]
    """95 %, by bootstrap over the images."""
    found_as_set: float
    """At the chain's own levels."""
    false_as_set: float
    """Detections an image that are no object's."""


class SweepPoint(NamedTuple):
    """What one value of a setting gives."""

    value: Any
    found: float
    false_alarms: float
    """An image."""
    ms: float


@cache
def images() -> list[LabelledImage]:
    """Return the images, simulated once."""
    return sea_images(IMAGES, IMAGES_SEED)


@cache
def spacing_m() -> float:
    """Return how far apart the range samples of the images are."""
    return load_sonar(shipped_file(SEA_SONAR)).dr_m


def point_of(name: str, pipeline: PipelineSettings) -> Point:
    """Return the point of a chain. Raises StageError."""
    return _point(name, pipeline, configured(pipeline))


def others(tell: Tell) -> list[Point]:
    """Return the points of the default chain and of OTHERS. Raises GivenUpError."""
    detector = DETECTORS["two-level"]
    points = []
    for done, name in enumerate(OTHERS):
        _go_on(tell, done / (len(OTHERS) + 1))
        setting = setting_of(name, (*EQUALIZERS, *FILTERS[name]), detector, ATTENTION[""])
        points.append(_point(name, setting.settings[len(setting.settings) // 2], setting))
    return [point_of(DEFAULT, PipelineSettings()), *points]


def _point(name: str, as_set: PipelineSettings, setting: Setting) -> Point:
    accuracy, own = accuracy_of(setting, images(), FALSE_ALARMS), score_of(as_set, images())
    (ms,) = milliseconds([as_set], images()[0].ping, ROUNDS)
    return Point(
        name, ms, accuracy.detection_probability, accuracy.interval, own.detection_probability, own.false_per_image
    )


def even_values(low: float, high: float, count: int, *, by_factors: bool, whole: bool) -> list[float]:
    """Return `count` values from end to end, each once: evenly, or by even factors; whole: rounded to integers."""
    values = np.geomspace(low, high, count) if by_factors else np.linspace(low, high, count)
    return list(dict.fromkeys(round(value) if whole else float(f"{value:.6g}") for value in values.tolist()))


def swept(state: State, path: str, values: Sequence[Any], tell: Tell) -> list[SweepPoint]:
    """Return what each value of a setting of A gives, at the chain's own levels; what the setting refuses is left out.

    Raises StageError, GivenUpError; PathError where it refuses all.
    """
    settings: list[tuple[Any, PipelineSettings]] = []
    for value in values:
        try:
            actions = with_numbers_first(state, SetSetting(path, value), spacing_m())
            settings.append((value, reduce(apply, actions, state).tuning.pipeline()))
        except PathError as error:
            refused = error
    if not settings:
        raise refused
    spent = milliseconds([each for _, each in settings], images()[0].ping, ROUNDS)
    points = []
    for done, ((value, each), ms) in enumerate(zip(settings, spent, strict=True)):
        _go_on(tell, done / len(settings))
        score = score_of(each, images())
        points.append(SweepPoint(value, score.detection_probability, score.false_per_image, ms))
    return points


def _go_on(tell: Tell, share: float) -> None:
    if not tell(share):
        raise GivenUpError


class Numeric(NamedTuple):
    """A number of the chain that can be swept."""

    path: str
    """For SetSetting."""
    label: str
    value: float
    """As it is."""
    whole: bool


def numbers_of(tuning: Tuning) -> list[Numeric]:
    """Return the numbers that the stages of a chain run by, those of the detector first. Raises StageError."""
    found: list[list[Numeric]] = []
    for place, stage in enumerate(configured_stages(written(tuning, spacing_m()).config.pipeline)):
        settings = msgspec.structs.asdict(stage.params)
        found.append([
            Numeric(f"pipeline.stage[{place}].{name}", f"{stage.name} {name}", float(value), isinstance(value, int))
            for name, value in settings.items() if isinstance(value, int | float) and not isinstance(value, bool)
        ])  # fmt: skip
    return [each for stage in reversed(found) for each in stage]
