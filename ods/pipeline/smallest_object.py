"""Settings derived from the smallest object that matters: samples averaged, windows and least region. Pure."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from ods.pipeline.stage.params import MeanRangeParams

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


def columns_of(object_m: float, dr_m: float, subsample: int = 0) -> Columns:
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


def leaves_numbers(stages: Sequence[dict[str, Any]], among: Sequence[dict[str, Any]]) -> bool:
    """Return whether a chain is made of stages `among`, FILTER and DETECTOR too, and says none of DECIDED itself."""
    used = {stage["use"] for stage in stages}
    named = {key for stage in stages for key in stage}
    return {FILTER, DETECTOR} <= used <= {stage["use"] for stage in among} and not named & set(DECIDED)


def with_numbers(stages: Sequence[dict[str, Any]], columns: Columns) -> tuple[dict[str, Any], ...]:
    """Return the stages with these numbers."""
    numbers: dict[str, dict[str, Any]] = {
        "equalize.mean_range": {"window": columns.window},
        FILTER: {"taps": columns.taps, "cutoff": columns.cutoff},
        DETECTOR: {"min_cells": columns.min_cells},
    }
    return tuple(stage | numbers.get(stage["use"], {}) for stage in stages)
