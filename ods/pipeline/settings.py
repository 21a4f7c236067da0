"""Settings of the `pipeline` package."""

from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec.structs import replace

from ods.base.choices import none_of
from ods.base.frames.mounting import MountingSettings
from ods.base.settings import NonNegative, Settings, slider
from ods.pipeline.range_image.settings import RangeImageSettings
from ods.pipeline.smallest_object import columns_of, leaves_numbers, with_numbers
from ods.pipeline.stage.params import BUILT_IN, STAGES, StageError, read_params, stage_label
from ods.pose.buffer import PoseSettings

StageTable = dict[str, Any]

DEFAULT_STAGES: tuple[StageTable, ...] = (
    {"use": "equalize.beam_gain"},
    {"use": "equalize.mean_range"},
    {"use": "equalize.local"},
    {"use": "filter.fir", "round_beams": 1.0},
    {"use": "detect.two_level", "high": 5.5, "strongest": 0.12, "border": 1.4},
)
"""The chain when the configuration names none; `PipelineSettings.at_spacing` gives it its windows."""


class AttentionSettings(Settings, frozen=True):
    """Far ranges only at every n-th ping [SSIE]."""

    near_m: Annotated[NonNegative, slider(0.0, 100.0, step=1.0, unit="m")] = 0.0
    """Nearer ranges are processed at each ping; 0: all."""
    every: Annotated[int, msgspec.Meta(ge=1, le=50), slider(1, 16)] = 4
    """Rings beyond `near_m`; each ping processes one."""
    margin_m: Annotated[NonNegative, slider(0.0, 20.0, step=0.5, unit="m")] = 5.0
    """Processed beyond a ring's borders."""
    subsample: Annotated[int, msgspec.Meta(ge=0, le=16), slider(0, 8, unit="samples")] = 0
    """Range samples averaged to one first; 0: as many as `pipeline.smallest_object_m` allows."""


class PipelineSettings(Settings, frozen=True):
    """Pings to detections."""

    plugins: tuple[Path, ...] = ()
    """Python files or modules."""
    stage: tuple[StageTable, ...] = ()
    """Tables of `use`, a stage's name, and its parameters. Empty: the default (docs/pipeline/README.md)."""
    smallest_object_m: Annotated[float, msgspec.Meta(ge=0.0, le=50.0), slider(0.0, 5.0, step=0.05, unit="m")] = 0.0
    """Smallest object that matters, along the range: decides averaging, filter and smallest region unless the stages
    do. 0: six range samples."""
    attention: AttentionSettings = AttentionSettings()
    """Ranges that are processed at each ping."""
    min_range_m: Annotated[NonNegative, slider(0.0, 10.0, step=0.1, unit="m")] = 0.1
    """Nearer samples are ignored."""
    beam_width_deg: Annotated[float, msgspec.Meta(ge=0.0, le=90.0), slider(0.0, 10.0, step=0.1, unit="deg")] = 0.0
    """Horizontal, -3 dB, if the sonar reports none; 0: the beam spacing."""
    vertical_half_deg: Annotated[float, msgspec.Meta(gt=0.0, le=90.0), slider(1.0, 45.0, step=0.5, unit="deg")] = 10.0
    """Half the vertical opening of a plane of beams."""
    range_image: RangeImageSettings = RangeImageSettings()
    """Of 3-D sonars."""

    def __post_init__(self) -> None:
        for index, stage in enumerate(self.stage):
            name = stage.get("use")
            if not isinstance(name, str):
                raise ValueError(f"stage[{index}].use: missing: the name of the stage")
            if name in BUILT_IN:
                try:
                    read_params(BUILT_IN[name], stage)
                except StageError as error:
                    raise ValueError(f"{stage_label(index, stage)}: {error}") from error
            elif not self._may_be_a_plug_ins(name):
                raise ValueError(f"stage[{index}].use: {none_of(name, BUILT_IN)}")
        if self.smallest_object_m > 0.0 and not leaves_numbers(self.chain(), DEFAULT_STAGES):
            raise ValueError("smallest_object_m: needs the default stages with their default windows")

    def _may_be_a_plug_ins(self, stage: str) -> bool:
        """Return whether a stage of that name has been registered in this process, or may yet be by the pipeline's."""
        if STAGES.may_add(self.plugins):
            return True
        from ods.pipeline.stage.registry import stage_names  # slow, and of use only where somebody has registered one

        return stage in stage_names()

    def chain(self) -> tuple[StageTable, ...]:
        """Return the stages to build."""
        return self.stage or DEFAULT_STAGES

    def at_spacing(self, dr_m: float) -> "PipelineSettings":
        """Return the settings with all numbers, for a spacing of range samples, m."""
        attention, stages = self.attention, self.chain()
        subsample = attention.subsample or 1
        if leaves_numbers(stages, DEFAULT_STAGES):
            columns = columns_of(self.smallest_object_m, dr_m, attention.subsample)
            stages, subsample = with_numbers(stages, columns), columns.subsample
        return replace(self, stage=stages, smallest_object_m=0.0, attention=replace(attention, subsample=subsample))


class PipelineConfig(Settings, frozen=True):
    """The part of the configuration that the pipeline process reads."""

    pose: PoseSettings
    pipeline: PipelineSettings
    mounting: MountingSettings = MountingSettings()
    """`[sonar.mounting]`."""
