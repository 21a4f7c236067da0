"""Compares the chain with others in speed and accuracy, and sweeps one setting.

The images, the others and the measures are those of `ods assess detect`; `ods.workbench.engine.measuring` measures.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import msgspec
import numpy as np

from ods.assess.detection.chains import DEFAULT
from ods.base.files.shipped import shipped_file
from ods.base.settings_file import load
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.configured import configured_stages
from ods.sim_sonar.sonar.settings import SonarFile
from ods.workbench.engine.background.own_process import GoesOn
from ods.workbench.model.chain.numbers import written
from ods.workbench.model.state import State, Tuning
from ods.workbench.model.words import called

SONAR = "sonars/seabat6012.toml"
"""That the images are of."""
IMAGES, IMAGES_SEED = 16, 4
"""The first of those of `ods assess detect`."""
FALSE_ALARMS = 1.0
"""An image, at which chains are compared."""
OTHERS = (
    DEFAULT, "no filter", "FIR 9", "FIR 15", "box 5", "median 5", "Wiener 9", "Gaussian 2.5", "FIR 9 x 3 beams",
)  # fmt: skip
"""That are compared: the default chain, and filters with the two-level detector."""


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


class Measured(NamedTuple):
    """What came of chains."""

    points: list[Point]
    others: list[Point]


def measured(
    report: GoesOn, chains: Mapping[str, PipelineSettings], others: Sequence[str], count: int
) -> Measured | None:
    """As `measuring.measured`, which is loaded where this is called."""
    from ods.workbench.engine import measuring

    return measuring.measured(report, chains, others, count)


def swept(report: GoesOn, state: State, path: str, values: Sequence[Any], count: int) -> list[SweepPoint] | None:
    """As `measuring.swept`, which is loaded where this is called."""
    from ods.workbench.engine import measuring

    return measuring.swept(report, state, path, values, count)


@cache
def spacing_m() -> float:
    """Return how far apart the range samples of the images are."""
    return load(shipped_file(SONAR), SonarFile).dr_m


def even_values(low: float, high: float, count: int, *, by_factors: bool, whole: bool) -> list[float]:
    """Return `count` values from end to end, each once: evenly, or by even factors; whole: rounded to integers."""
    values = np.geomspace(low, high, count) if by_factors else np.linspace(low, high, count)
    return list(dict.fromkeys(round(value) if whole else float(f"{value:.6g}") for value in values.tolist()))


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
            Numeric(f"pipeline.stage[{place}].{name}", _label(stage.name, name), float(value), isinstance(value, int))
            for name, value in settings.items() if isinstance(value, int | float) and not isinstance(value, bool)
        ])  # fmt: skip
    return [each for stage in reversed(found) for each in stage]


def _label(stage: str, setting: str) -> str:
    name, unit = called(setting)
    return f"{stage}: {name}{unit and f', {unit}'}"
