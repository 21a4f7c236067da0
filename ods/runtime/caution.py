"""What a list that is valid cannot vouch for all the same, in words."""

import math
from collections.abc import Sequence
from datetime import UTC, datetime

from ods.base.clock import NS
from ods.messages import ObstacleList, UnseenPart

LOUD_BOTTOM_DB = 12.0
"""Echoes need no more over the background where the bottom is smooth."""
MARGIN_DB = 8.0
"""What is so much louder than an echo has to be is in the list nearly always (docs/assess-sea.md)."""


def cautions(told: ObstacleList) -> list[str]:
    """Return what the sonar did not show of the sector, how loud objects must be where that is much, and what an
    operator said to ignore.

    It is much where the bottom's crests are loud, or the detector's levels are set high.
    """
    said = [f"not seen: {told.unseen_why} ({where(told.unseen)})"] if told.unseen else []
    if told.caution:
        said.append(told.caution)
    if told.heard_from_db is not None and told.heard_from_db > LOUD_BOTTOM_DB:
        least_db = told.heard_from_db + MARGIN_DB
        said.append(
            f"objects less than {least_db:.0f} dB over the background may be missing: loud bottom, or high levels"
        )
    return said + ignored(told)


def ignored(told: ObstacleList) -> list[str]:
    """Return which obstacles of a list are ignored, by whom, why and until when: a line for each veto."""
    ids: dict[int, list[str]] = {}
    for each in told.obstacles:
        if each.ignored_by >= 0:
            ids.setdefault(each.ignored_by, []).append(str(each.id))
    said = []
    for veto in told.vetoes:
        if veto.number in ids:
            until = datetime.fromtimestamp(veto.until_utc_ns / NS, UTC)
            whom = ", ".join(ids[veto.number])
            said.append(f"{whom} ignored by {veto.author} until {until:%H:%M:%S} UTC: {veto.reason}")
    return said


def where(unseen: Sequence[UnseenPart]) -> str:
    """Return what the unseen parts span: bearings and ranges."""
    left = math.degrees(min(part.bearing_min_rad for part in unseen))
    right = math.degrees(max(part.bearing_max_rad for part in unseen))
    near, far = min(part.range_min_m for part in unseen), max(part.range_max_m for part in unseen)
    return f"within {left:.0f} to {right:.0f} deg, {near:.0f} to {far:.0f} m"
