"""One point of the chart."""

from typing import Literal

import msgspec

from ods.missions.statistics import Paired, Rate


class Point(msgspec.Struct, frozen=True, kw_only=True):
    """A variant at a speed of the vehicle."""

    name: str
    varies: str
    speed_m_s: float
    fidelity: Literal["detections", "images"]
    ms: float
    """Pipeline and tracker, CPU time a ping, see `ms_a_ping`."""
    pings_a_second: float
    collision: Rate
    against_first: Paired
    """The chart's first variant and this one, at this speed and fidelity, in the same worlds."""
    success: Rate
    first_listed_m: float | None
    """Median over missions of the mean distance at which obstacles were listed first; none: none was."""
    evasions_of_nothing: float
    """Mean a mission."""
