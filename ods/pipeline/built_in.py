"""Imports every module with stages that come with ODS: they register themselves."""

from ods.pipeline.detect import cfar, levels
from ods.pipeline.equalize import background, beam_gain, by_range, local
from ods.pipeline.filter import iir, linear, median, min_object, over_pings, wiener

__all__ = [
    "background",
    "beam_gain",
    "by_range",
    "cfar",
    "iir",
    "levels",
    "linear",
    "local",
    "median",
    "min_object",
    "over_pings",
    "wiener",
]
