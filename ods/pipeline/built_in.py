"""Imports every module with stages that come with ODS: they register themselves."""

from ods.pipeline.detect import cfar, levels
from ods.pipeline.equalize import beam_gain, by_block, by_range
from ods.pipeline.filter import iir, linear, median, min_object, over_pings, wiener

__all__ = [
    "beam_gain",
    "by_block",
    "by_range",
    "cfar",
    "iir",
    "levels",
    "linear",
    "median",
    "min_object",
    "over_pings",
    "wiener",
]
