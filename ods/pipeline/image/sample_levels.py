"""Levels of a ping's samples."""

import math

from ods.messages import Ping, SampleType

FULL_SCALE: dict[SampleType, float] = {"u1": 255.0, "u2": 65535.0, "f4": math.inf}
"""Highest sample of each type."""


def db_a_count(ping: Ping) -> float:
    """Return what a count is worth where counts are logarithms, dB; 0 where they are not."""
    if ping.scale == "linear":
        return 0.0
    return 20.0 / ping.scale_factor if ping.scale == "log8" else ping.scale_factor
