"""Stages found by name: those that a configuration names, with their parameters. An error of one is reported with its
name."""

from typing import Any, NamedTuple

from ods.base.choices import none_of
from ods.base.plugins import reason
from ods.base.settings import Settings
from ods.pipeline.detect import cfar, levels  # noqa: F401  these modules register the stages that come with ODS
from ods.pipeline.equalize import background, beam_gain, by_range, local  # noqa: F401
from ods.pipeline.filter import iir, linear, median, min_object, over_pings, wiener  # noqa: F401
from ods.pipeline.image.fan import Fan
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.params import StageError, read_params, stage_label
from ods.pipeline.stage.registry import REGISTERED, Stage


class ConfiguredStage(NamedTuple):
    """One entry of `[[pipeline.stage]]`."""

    label: str
    """How complaints name it."""
    stage: Stage
    params: Settings

    @property
    def name(self) -> str:
        """The stage's own."""
        return self.stage.name

    def prepared(self, fan: Fan) -> Any:
        """Return the stage's step, or the `PreparedDetector` of one that detects. Raises StageError."""
        try:
            return self.stage.prepare(self.params, fan)
        except Exception as error:
            raise error_of(self.label, error) from error


def stage_names() -> list[str]:
    """Return the names of all stages known now, sorted."""
    return sorted(REGISTERED)


def find_stage(name: str) -> Stage:
    """Return a stage by its name. Raises StageError, which lists the names that are known."""
    if name not in REGISTERED:
        raise StageError(f"use: {none_of(name, stage_names())}")
    return REGISTERED[name]


def configured_stages(settings: PipelineSettings) -> list[ConfiguredStage]:
    """Return the stages of the whole chain. Raises StageError."""
    stages = []
    for index, entry in enumerate(settings.chain()):
        label = f"pipeline.{stage_label(index, entry)}"
        try:
            stage = find_stage(entry["use"])
            stages.append(ConfiguredStage(label, stage, read_params(stage.params, entry)))
        except StageError as error:
            raise StageError(f"{label}: {error}") from error
    if [entry.stage.kind == "detect" for entry in stages] != [False] * (len(stages) - 1) + [True]:
        raise StageError("pipeline.stage: exactly the last stage must be one that detects")
    return stages


def error_of(label: str, error: Exception) -> StageError:
    """Return the complaint about whatever a stage raised, which may be anybody's code."""
    return StageError(f"{label}: {reason(error)}")
