"""Chains measured on the images of `ods assess detect`, of which this is a small, quick part.

For a process of its own: simulator and scipy.stats take 80 MB. The images are simulated once a process.
"""

from collections.abc import Mapping, Sequence
from functools import cache, reduce
from typing import Any

from ods.assess.detection.chains import ATTENTION, DEFAULT, DETECTORS, EQUALIZERS, FILTERS, Setting, setting_of
from ods.assess.detection.measure import accuracy_of, milliseconds, score_of
from ods.assess.detection.own import configured
from ods.assess.images.labelled import LabelledImage
from ods.assess.images.sea import sea_images
from ods.pipeline.settings import PipelineSettings
from ods.workbench.engine.assessment import FALSE_ALARMS, IMAGES_SEED, Measured, Point, SweepPoint, spacing_m
from ods.workbench.engine.background.own_process import GoesOn
from ods.workbench.model.actions import SetSetting
from ods.workbench.model.apply import apply
from ods.workbench.model.chain.numbers_first import with_numbers_first
from ods.workbench.model.paths import PathError
from ods.workbench.model.state import State

ROUNDS = 5


@cache
def images(count: int) -> list[LabelledImage]:
    """Return so many images."""
    return sea_images(count, IMAGES_SEED)


def measured(
    report: GoesOn, chains: Mapping[str, PipelineSettings], others: Sequence[str], count: int
) -> Measured | None:
    """Return the points of chains by their names, and those of `assessment.OTHERS`, by so many images; None: given up.

    Raises StageError.
    """
    found = []
    for done, name in enumerate(others):
        if not report(done / len(others)):
            return None
        found.append(_other(name, count))
    report(1.0)
    return Measured([point_of(name, chain, count) for name, chain in chains.items()], found)


def point_of(name: str, pipeline: PipelineSettings, count: int) -> Point:
    """Return the point of a chain. Raises StageError."""
    return _point(name, pipeline, configured(pipeline), count)


def _other(name: str, count: int) -> Point:
    """Return the point of the default chain, or of one of FILTERS with the two-level detector."""
    if name == DEFAULT:
        return point_of(DEFAULT, PipelineSettings(), count)
    setting = setting_of(name, (*EQUALIZERS, *FILTERS[name]), DETECTORS["two-level"], ATTENTION[""])
    return _point(name, setting.settings[len(setting.settings) // 2], setting, count)


def _point(name: str, as_set: PipelineSettings, setting: Setting, count: int) -> Point:
    accuracy, own = accuracy_of(setting, images(count), FALSE_ALARMS), score_of(as_set, images(count))
    (ms,) = milliseconds([as_set], images(count)[0].ping, ROUNDS)
    return Point(
        name, ms, accuracy.detection_probability, accuracy.interval, own.detection_probability, own.false_per_image
    )


def swept(report: GoesOn, state: State, path: str, values: Sequence[Any], count: int) -> list[SweepPoint] | None:
    """Return what each value of a setting of A gives, at the chain's own levels; what the setting refuses is left out.

    None: given up. Raises StageError; PathError where it refuses all.
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
    spent = milliseconds([each for _, each in settings], images(count)[0].ping, ROUNDS)
    points = []
    for done, ((value, each), ms) in enumerate(zip(settings, spent, strict=True)):
        if not report(done / len(settings)):
            return None
        score = score_of(each, images(count))
        points.append(SweepPoint(value, score.detection_probability, score.false_per_image, ms))
    return points
