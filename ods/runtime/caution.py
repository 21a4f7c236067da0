"""Limitations of a valid obstacle list, as text."""

import math
from collections.abc import Sequence
from datetime import UTC, datetime

from ods.base.clock import NS
from ods.messages import ObstacleList, UnseenPart

LOUD_BOTTOM_DB = 12.0
"""Detection threshold over the background where the bottom is smooth, dB, at most."""
MARGIN_DB = 8.0
"""Level over the detection threshold from which on objects are nearly always in the list, dB (docs/assess/sea.md)."""


def cautions(message: ObstacleList) -> list[str]:
    """Return a line for each limitation: parts of the sector not observed, a high detection threshold, vetoes.

    The threshold is high where the bottom's crests are loud, or the detector's levels are set high.
    """
    said = [f"not seen: {message.unseen_why} ({where(message.unseen)})"] if message.unseen else []
    if message.caution:
        said.append(message.caution)
    if message.heard_from_db is not None and message.heard_from_db > LOUD_BOTTOM_DB:
        least_db = message.heard_from_db + MARGIN_DB
        said.append(
            f"objects less than {least_db:.0f} dB over the background may be missing: loud bottom, or high levels"
        )
    return said + ignored(message)


def ignored(message: ObstacleList) -> list[str]:
    """Return a line for each veto: the ignored obstacles, by whom, why and until when."""
    ids: dict[int, list[str]] = {}
    for each in message.obstacles:
        if each.ignored_by >= 0:
            ids.setdefault(each.ignored_by, []).append(str(each.id))
    said = []
    for veto in message.vetoes:
        if veto.number in ids:
            until = datetime.fromtimestamp(veto.until_utc_ns / NS, UTC)
            whom = ", ".join(ids[veto.number])
            said.append(f"{whom} ignored by {veto.author} until {until:%H:%M:%S} UTC: {veto.reason}")
    return said


def where(unseen: Sequence[UnseenPart]) -> str:
    """Return the bearings and ranges that the unseen parts span."""
    left = math.degrees(min(part.bearing_min_rad for part in unseen))
    right = math.degrees(max(part.bearing_max_rad for part in unseen))
    near, far = min(part.range_min_m for part in unseen), max(part.range_max_m for part in unseen)
    return f"within {left:.0f} to {right:.0f} deg, {near:.0f} to {far:.0f} m"
