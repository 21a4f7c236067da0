"""Marks on the timeline: pings that are missing, objects that come and go, bookmarks."""

import contextlib
import time
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from ods.base.errors import OdsError
from ods.tracker.existence.lifecycle import ACTIVE, STAND_BY
from ods.workbench.engine.data import Data
from ods.workbench.engine.mission.tracked import Course, Tracked
from ods.workbench.model.state import Bookmark

PAUSE_S = 0.001
"""Between two pings that are read only for their numbers: what the user does comes first."""

Kind = Literal["gap", "new", "lost", "bookmark"]


class Mark(NamedTuple):
    """A ping worth going to."""

    place: int
    """In the data."""
    kind: Kind
    text: str


def gap_marks(data: Data, give_up: Callable[[], bool] = lambda: False) -> list[Mark]:
    """Return where ping numbers are left out, at the next ping that can be read. It reads all pings, which lasts: not
    for the server's loop."""
    numbers: list[tuple[int, int]] = []
    for place in range(len(data.pings)):
        if give_up():
            return []
        with contextlib.suppress(OdsError):  # the page of such a ping shows why it cannot be read
            numbers.append((place, data.pings[place].ping_number))
        time.sleep(PAUSE_S)
    return gaps_between(numbers)


def gaps_between(numbers: Sequence[tuple[int, int]]) -> list[Mark]:
    """Return where numbers are left out; numbers: place and number of each ping that can be read, in order."""
    missing = ((place, after - before - (place - former)) for (former, before), (place, after) in pairwise(numbers))
    return [Mark(place, "gap", f"{count} ping{'s' * (count > 1)} missing") for place, count in missing if count > 0]


def track_marks(result: Tracked) -> list[Mark]:
    """Return where objects are first reported, and where they are no longer active or stand-by.

    What the map knew before the mission is not new, and what is seen at its end is not lost.
    """
    return [mark for course in result.courses for mark in _of_course(course, result)]


def _of_course(course: Course, result: Tracked) -> Iterable[Mark]:
    seen = course.place[np.isin(course.state, (ACTIVE, STAND_BY))]
    if not len(seen):
        return
    if course.first_seen_s >= 0.0:
        yield Mark(int(seen[0]), "new", f"{result.name_of(course.id)} is new")
    if seen[-1] < len(result.t_s) - 1:
        yield Mark(int(seen[-1]) + 1, "lost", f"{result.name_of(course.id)} is lost")


def bookmark_marks(bookmarks: Sequence[Bookmark]) -> list[Mark]:
    """Return the bookmarks of a state."""
    return [Mark(each.ping, "bookmark", each.text) for each in bookmarks]


def thinned(marks: Iterable[Mark], last: int, most: int) -> list[Mark]:
    """Return marks of which no two of a kind share one of `most` equal parts of the places 0 to `last`: the first of
    them stands for all, and says how many there are."""
    parts: dict[tuple[Kind, int], list[Mark]] = {}
    for mark in sorted(marks):
        parts.setdefault((mark.kind, mark.place * most // (last + 1)), []).append(mark)
    return [
        first if not others else first._replace(text=f"{first.text}, and {len(others)} more")
        for first, *others in parts.values()
    ]
