"""What is known of each ping of a mission beside the objects: its echoes, its image's faults, its list's validity."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats, Ints
from ods.messages import ObstacleList
from ods.offline.mission import Found

BAD = "bad ping"
NO_LIST = "no list"


@dataclass(frozen=True, eq=False)
class PingLog:
    """Of a mission of n pings, in which k echoes were detected."""

    number: Ints
    """(n,) the sonar's own count."""
    fault: tuple[str, ...]
    """(n,) why the image, or a part of it, says nothing; empty: all of it was of use."""
    invalid: tuple[str, ...]
    """(n,) why a planner must not trust the list of the ping; empty: it is valid."""
    echo_place: Ints
    """(k,) of its ping, rising."""
    echo_range_m: Floats
    """(k,) slant range of the circle's centre."""
    echo_bearing_rad: Floats
    """(k,)."""
    echo_radius_m: Floats
    """(k,)."""


def log_of(found: Sequence[Found], lists: Sequence[ObstacleList | None]) -> PingLog:
    """Return what is known of pings; lists: of the same pings."""
    echoes = [
        (place, echo.range_m, echo.bearing_rad, echo.radius_m)
        for place, each in enumerate(found)
        for echo in (() if each.detections is None else each.detections.detections)
    ]
    columns = np.array(echoes, np.float64).reshape(-1, 4).T
    return PingLog(
        np.array([each.ping_number for each in found], np.int64),
        tuple(_fault(each) for each in found),
        tuple(NO_LIST if told is None else "" if told.valid else ", ".join(told.reasons) for told in lists),
        columns[0].astype(np.int64),
        *columns[1:],
    )


def _fault(found: Found) -> str:
    told = found.detections
    if told is None:
        return BAD
    if not told.usable:
        return told.unseen_why or "drop-out"
    return f"{told.unseen_share:.0%} unseen: {told.unseen_why}" if told.unseen_share > 0.0 else ""
