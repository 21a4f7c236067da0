"""Marks of the timeline: against what is put into made-up data."""

from typing import Any

import numpy as np
import pytest

from ods.messages import Ping
from ods.recording.errors import RecordingError
from ods.workbench.engine.data import Data
from ods.workbench.engine.mission.marks import Mark, bookmark_marks, gap_marks, thinned, track_marks
from ods.workbench.model.state import Bookmark, DataReference
from tests.pipeline.pings import make_ping
from tests.workbench.pages.test_observer_views import ASLEEP, ONE, tracked


def test_gaps_are_reported_by_the_numbers_of_pings() -> None:
    pings = [make_ping(np.zeros((4, 25), np.uint8), ping_number=number) for number in (3, 4, 7, 8, 10)]
    data = Data(DataReference(), pings)
    assert gap_marks(data) == [Mark(2, "gap", "2 pings missing"), Mark(4, "gap", "1 ping missing")]
    assert gap_marks(data, lambda: True) == []


class Torn(list[Ping]):
    """Pings of which the third cannot be read."""

    def __getitem__(self, place: Any) -> Any:
        if place == 2:
            raise RecordingError("ping 2: torn")
        return super().__getitem__(place)


def test_a_ping_that_cannot_be_read_hides_no_gap() -> None:
    pings = [make_ping(np.zeros((4, 25), np.uint8), ping_number=number) for number in (3, 4, 5, 6, 9)]
    assert gap_marks(Data(DataReference(), Torn(pings))) == [Mark(4, "gap", "2 pings missing")]


def test_objects_come_and_go_where_lists_say_so() -> None:
    result = tracked({4: ONE, 5: {1: "active", 2: "active", 3: "stand_by"}, 6: dict.fromkeys(range(3, 8), "active")})
    assert {(mark.place, mark.kind, mark.text.split()[1]) for mark in track_marks(result)} == {
        (2, "new", "4"), (7, "lost", "4"), (1, "new", "5"), (4, "lost", "5"), (3, "new", "6")
    }  # fmt: skip


def test_what_sleeps_in_the_map_neither_comes_nor_goes() -> None:
    assert track_marks(tracked({4: dict.fromkeys(range(8), ASLEEP)})) == []


def test_bookmarks_are_marks() -> None:
    assert bookmark_marks([Bookmark(3, "echo")]) == [Mark(3, "bookmark", "echo")]


@pytest.mark.parametrize(("most", "places"), [(100, [0, 1, 50, 99]), (10, [0, 50, 99]), (1, [0])])
def test_marks_that_would_cover_each_other_are_one(most: int, places: list[int]) -> None:
    marks = [Mark(place, "new", f"object {place}") for place in (99, 0, 50, 1)]
    left = thinned([*marks, Mark(0, "lost", "x")], 99, most)
    assert [mark.place for mark in left if mark.kind == "new"] == places
    others = [mark.text.partition(", and ")[2].partition(" ")[0] for mark in left]
    assert sum(1 + int(count or 0) for count in others) == 5
