"""The stages that a configuration names, with their parameters; an error of one is reported with its name."""

from typing import Any, NamedTuple

from ods.base.plugins import reason
from ods.base.settings import Settings
from ods.pipeline.image.fan import Fan
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.params import StageError, read_params, stage_label
from ods.pipeline.stage.registry import Stage, find_stage


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
            raise blamed(self.label, error) from error


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


def blamed(label: str, error: Exception) -> StageError:
    """Return the complaint about whatever a stage raised, which may be anybody's code."""
    return StageError(f"{label}: {reason(error)}")
