"""What lies over an echogram, by hand: ranges of tracks, faults of images, validity of lists."""

import math

import msgspec
import numpy as np
import pytest

from ods.messages import Detections, ObstacleList
from ods.offline.mission import Found
from ods.workbench.engine.echogram.layers import Span, layers_of, spans
from ods.workbench.engine.echogram.levels import Echogram
from ods.workbench.engine.mission.ping_log import BAD, NO_LIST, log_of
from tests.export import mission
from tests.workbench.pages.test_observer_views import AWAKE, ONE, PINGS, tracked

BEHIND = math.pi - math.atan2(90.0, 15.0)
"""About the bearing of the object: nearly 90 m to starboard of a vehicle that heads east, and 15 m behind it."""
RANGES = [math.hypot(90.0 - place, 15.0, 8.0) for place in range(PINGS)]
"""Of an object that goes north at 1 m/s from 10 m north, 5 m east, 2 m down, seen from 100, 20, 10."""


def echogram(*bearings: float, per_column: int = 1) -> Echogram:
    count = -(-PINGS // per_column)
    return Echogram(
        np.zeros((count, 10), np.float32), PINGS, per_column, 10.0, PINGS, np.array(bearings), np.zeros(count)
    )


def test_a_track_goes_where_its_ranges_are_with_a_line_for_each_state() -> None:
    layers = layers_of(tracked({4: ONE}), echogram(-math.pi, math.pi), None)
    assert [(way.role, way.id, list(way.place)) for way in layers.tracks] == [
        ("active", "4", [2, 3, 4, 5]), ("stand_by", "4", [5, 6, 7]), ("hibernated", "4", [7])
    ]  # fmt: skip
    for way in layers.tracks:
        assert list(way.range_m) == pytest.approx([RANGES[place] for place in way.place], abs=1e-3)


def test_of_one_beam_only_what_reaches_into_it_is_shown() -> None:
    result = tracked({4: dict.fromkeys(range(PINGS), AWAKE)})
    seen = layers_of(result, echogram(BEHIND - 0.02, BEHIND, BEHIND + 0.02), 1)
    assert [way.label for way in seen.tracks] == ["track 4"]
    assert layers_of(result, echogram(-0.4, 0.0, 0.4), 1).tracks == []
    assert layers_of(result, echogram(-0.4, 0.0, 0.4), None).tracks == []  # out of the fan
    assert list(layers_of(result, echogram(0.2, 0.25, 0.3), 1).echoes.place) == list(range(PINGS))
    assert list(layers_of(result, echogram(0.2, 0.25, 0.3), 7).echoes.place) == []  # there is no such beam


def test_a_line_is_interrupted_where_the_lists_left_the_object_out() -> None:
    result = tracked({4: dict.fromkeys((1, 2, 6, 7), AWAKE)})
    ways = layers_of(result, echogram(-math.pi, math.pi), None).tracks
    assert [list(way.place) for way in ways] == [[1, 2], [6, 7]]


def test_echoes_of_one_cell_are_one() -> None:
    layers = layers_of(tracked({}), echogram(-math.pi, math.pi, per_column=4), None)
    assert list(layers.echoes.place) == [0, 4]
    assert list(layers.echoes.range_m) == [30.0, 30.0]


def found(number: int, detections: Detections | None) -> Found:
    return Found(number, number, number, number, [], detections, 1.0)


def test_faults_and_validity_are_said_for_each_ping() -> None:
    seen, replace = mission.DETECTIONS, msgspec.structs.replace
    lost = replace(seen, usable=False, unseen_share=1.0, unseen_why="level fallen")
    partly = replace(seen, unseen_share=0.25, unseen_why="interference")
    valid = replace(mission.LIST, valid=True, reasons=[])
    lists: list[ObstacleList | None] = [valid, valid, mission.LIST, mission.LIST, None]
    log = log_of([found(1, seen), found(2, lost), found(3, lost), found(7, partly), found(8, None)], lists)
    assert log.fault == ("", "level fallen", "level fallen", "25% unseen: interference", BAD)
    assert spans(log.invalid) == [Span(2, 4, "no pose, sonar: silent"), Span(4, 5, NO_LIST)]
    assert log.echo_place.tolist() == [0, 1, 2, 3]


def test_missing_pings_stand_before_the_next_one() -> None:
    result = tracked({})
    number = result.log.number.copy()
    number[3:] += 2
    object.__setattr__(result.log, "number", number)
    assert layers_of(result, echogram(-1.0, 1.0), None).faults == [Span(3, 3, "2 pings missing")]
