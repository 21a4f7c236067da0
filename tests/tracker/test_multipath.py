"""Obstacles that are likely echoes of others by a longer way bear whose."""

import numpy as np

from ods.messages import Obstacle
from ods.tracker.output.multipath import marked

HEAD = np.array([10.0, 0.0, 5.0])


def obstacle(id_: int, range_m: float, bearing_deg: float, radius_m: float = 1.0) -> Obstacle:
    bearing, away = np.radians(bearing_deg), range_m + radius_m
    place = (10.0 + float(away * np.cos(bearing)), float(away * np.sin(bearing)), 5.0)
    return Obstacle(
        id_, "active", place, (0.0, 0.0, 0.0), radius_m, (0.1, 0.1, 2.0), (0.1, 0.1, 0.1), 0.1, 0, 0, 9, 0.99
    )


def test_what_stands_behind_another_by_the_longer_way_is_marked_and_nothing_else() -> None:
    body, echo = obstacle(3, 30.0, 12.0, 1.5), obstacle(5, 36.2, 12.2, 0.6)
    others = [obstacle(6, 36.0, 20.0), obstacle(7, 42.0, 12.0), obstacle(8, 24.0, 4.0), obstacle(9, 36.0, -168.0)]
    reported = {each.id: each.multipath_of for each in marked([body, echo, *others], HEAD, [6.0])}
    assert reported == {3: -1, 5: 3, 6: -1, 7: -1, 8: -1, 9: -1}


def test_without_a_longer_way_lists_are_as_they_are() -> None:
    obstacles = [obstacle(3, 30.0, 12.0), obstacle(5, 36.0, 12.0)]
    assert marked(obstacles, HEAD, []) is obstacles
    assert marked(obstacles[:1], HEAD, [6.0]) == obstacles[:1]
