"""Imports every module with stages that come with ODS: they register themselves."""

from ods.pipeline import (
    beam_gain,
    cfar,
    detect,
    equalize,
    local,
    median,
    opening,
    over_pings,
    recursive,
    smooth,
    wiener,
)

__all__ = [
    "beam_gain",
    "cfar",
    "detect",
    "equalize",
    "local",
    "median",
    "opening",
    "over_pings",
    "recursive",
    "smooth",
    "wiener",
]
