"""Settings of the `pipeline` package, and the numbers that follow from the smallest object that matters."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import msgspec
from msgspec.structs import replace

from ods.base.choices import none_of
from ods.base.frames.mounting import MountingSettings
from ods.base.settings import NonNegative, PositiveInt, Settings, slider
from ods.pipeline.stage.params import BUILT_IN, STAGES, MeanRangeParams, StageError, read_params, stage_label
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

AUTOMATIC = 6.0
"""Range samples of the smallest object where no size is set."""
_FEWEST, _MOST = 2.0, 64.0
"""Columns that an object has, for its filter and its region: fewer are no shape, more only cost time."""
_ENOUGH = 3.0
"""Columns that are left of an object where samples are averaged."""
_LARGEST_STRIDE = 16
_BELT_OBJECTS = 8.0
"""Surroundings by which a range is equalized, in smallest objects, where that is more than the stage's own window."""

FILTER = "filter.fir"
DETECTOR = "detect.two_level"
DECIDED = ("window", "taps", "cutoff", "object_m", "min_cells")
"""Parameters of stages that follow from the smallest object, where no table has one of them."""


class AttentionSettings(Settings, frozen=True):
    """Processing of far ranges at every n-th ping only [SSIE]."""

    near_m: Annotated[NonNegative, slider(0.0, 100.0, step=1.0, unit="m")] = 0.0
    """Nearer ranges are processed at each ping; 0: all."""
    every: Annotated[int, msgspec.Meta(ge=1, le=50), slider(1, 16)] = 4
    """Number of range rings beyond `near_m`, of which each ping processes one."""
    margin_m: Annotated[NonNegative, slider(0.0, 20.0, step=0.5, unit="m")] = 5.0
    """Range processed beyond a ring's borders."""
    subsample: Annotated[int, msgspec.Meta(ge=0, le=16), slider(0, 8, unit="samples")] = 0
    """Range samples averaged to one first; 0: as many as `pipeline.smallest_object_m` allows."""


class RangeImageSettings(Settings, frozen=True):
    """3-D sonars, which do not use the stages."""

    least_pixels: Annotated[PositiveInt, slider(1, 50)] = 6
    """Objects of fewer pixels are dropped as noise."""
    noise_m: Annotated[NonNegative, slider(0.0, 1.0, step=0.01, unit="m")] = 0.1
    """Largest difference in range of neighbouring pixels of one object, beyond that of a surface 10 degrees off the
    line
    of sight."""
    largest_m: Annotated[float, msgspec.Meta(ge=0.1, le=100.0), slider(0.2, 10.0, step=0.1, unit="m")] = 1.0
    """Largest radius: larger objects, such as walls, are cut into pieces in cells fixed in the world."""
    bottom_m: Annotated[NonNegative, slider(0.0, 3.0, step=0.05, unit="m")] = 0.3
    """Points lower over an even bottom do not belong to objects; 0: the bottom is not removed."""


class PipelineSettings(Settings, frozen=True):
    """Pings to detections."""

    plugins: tuple[Path, ...] = ()
    """Python files or modules."""
    stage: tuple[StageTable, ...] = ()
    """Tables of `use`, a stage's name, and its parameters. Empty: the default (docs/pipeline/README.md)."""
    smallest_object_m: Annotated[float, msgspec.Meta(ge=0.0, le=50.0), slider(0.0, 5.0, step=0.05, unit="m")] = 0.0
    """Smallest object that matters, along the range: sets averaging, filter and smallest region unless the stages do.
    0: six range samples."""
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
        if self.smallest_object_m > 0.0 and not leaves_numbers(self.chain()):
            raise ValueError("smallest_object_m: needs the default stages with their default windows")

    def _may_be_a_plug_ins(self, stage: str) -> bool:
        """Return whether a stage of that name has been registered in this process, or may yet be by the pipeline's."""
        if STAGES.may_add(self.plugins):
            return True
        from ods.pipeline.stage.registry import REGISTERED  # slow, and of use only where somebody has registered one

        return stage in REGISTERED

    def chain(self) -> tuple[StageTable, ...]:
        """Return the stages to build."""
        return self.stage or DEFAULT_STAGES

    def at_spacing(self, dr_m: float) -> "PipelineSettings":
        """Return the settings with all numbers, for a spacing of range samples, m."""
        attention, stages = self.attention, self.chain()
        subsample = attention.subsample or 1
        if leaves_numbers(stages):
            columns = columns_of(self.smallest_object_m, dr_m, attention.subsample)
            stages, subsample = with_numbers(stages, columns), columns.subsample
        return replace(self, stage=stages, smallest_object_m=0.0, attention=replace(attention, subsample=subsample))


class PipelineConfig(Settings, frozen=True):
    """The part of the configuration that the pipeline process reads."""

    pose: PoseSettings
    pipeline: PipelineSettings
    mounting: MountingSettings = MountingSettings()
    """`[sonar.mounting]`."""


class Columns(NamedTuple):
    """A chain's numbers, in columns of its image."""

    subsample: int
    """Range samples that are averaged to one column."""
    window: int
    """Of `equalize.mean_range`."""
    taps: int
    cutoff: float
    """Of FILTER."""
    min_cells: int
    """Of DETECTOR."""


def columns_of(object_m: float, dr_m: float, subsample: int) -> Columns:
    """Return the numbers for objects from `object_m` on, 0: of AUTOMATIC samples, in range samples `dr_m` apart.

    subsample: samples that are averaged; 0: as many as leave an object _ENOUGH columns. The filter passes what is
    longer than an object, and the least region is two thirds of one in a single beam.
    """
    samples = object_m / dr_m if object_m > 0.0 else AUTOMATIC
    stride = subsample or max(1, math.floor(min(samples / _ENOUGH + 1e-6, _LARGEST_STRIDE)))
    length = min(max(samples / stride, _FEWEST), _MOST)
    return Columns(
        subsample=stride,
        window=round(max(MeanRangeParams().window / stride, _BELT_OBJECTS * length)),
        taps=2 * math.floor(0.75 * length + 1e-6) + 1,
        cutoff=3.0 / (5.0 * length),
        min_cells=round(2.0 * length / 3.0),
    )


def leaves_numbers(stages: Sequence[StageTable]) -> bool:
    """Return whether a chain is made of default stages, FILTER and DETECTOR too, and says none of DECIDED itself."""
    used = {stage["use"] for stage in stages}
    named = {key for stage in stages for key in stage}
    return {FILTER, DETECTOR} <= used <= {stage["use"] for stage in DEFAULT_STAGES} and not named & set(DECIDED)


def with_numbers(stages: Sequence[StageTable], columns: Columns) -> tuple[StageTable, ...]:
    """Return the stages with these numbers."""
    numbers: dict[str, StageTable] = {
        "equalize.mean_range": {"window": columns.window},
        FILTER: {"taps": columns.taps, "cutoff": columns.cutoff},
        DETECTOR: {"min_cells": columns.min_cells},
    }
    return tuple(stage | numbers.get(stage["use"], {}) for stage in stages)
