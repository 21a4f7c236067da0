"""What the observer's menu draws of a mission."""

import math
from collections import Counter
from collections.abc import Mapping

import numpy as np
import pytest

from ods.base.frames.mounting import AT_ORIGIN
from ods.messages import ClosestApproach, Obstacle, ObstacleList, Prediction, TrackState
from ods.offline.mission import Found
from ods.workbench.engine.mission.tracked import Beside, Collecting, Tracked
from ods.workbench.pages.mission import plan as observer_plan, times as observer_times
from ods.workbench.web.views.plan_view import Circle, Ellipse, Line
from tests.export import mission

NS = 1_000_000_000
PINGS = 8
Lives = Mapping[int, Mapping[int, TrackState]]
AWAKE: TrackState = "active"
ASLEEP: TrackState = "hibernated"


def obstacle(identity: int, place: int, state: TrackState) -> Obstacle:
    """Return one that goes north at 1 m/s, first seen at the first ping."""
    return Obstacle(
        identity, state, (10.0 + place, 5.0, 2.0), (1.0, 0.0, 0.0), 1.5, (2.0, 1.0, 3.0), (0.1, 0.1, 0.3), 0.2,
        mission.UTC_NS, mission.UTC_NS, 3, 0.9, covariance_ne=0.5, cpa=ClosestApproach(4.0, 3.0, 0.5),
        predicted=[Prediction(5.0, (15.0 + place, 5.0, 2.0), (2.5, 1.5, 3.0))],
    )  # fmt: skip


def tracked(states: Lives) -> Tracked:
    """Return a mission of one ping a second; states: of each object, by ping."""
    collecting = Collecting()
    for place in range(PINGS):
        t_ns = mission.T_NS + place * NS
        listed = [obstacle(i, place, by[place]) for i, by in states.items() if place in by]
        reported = ObstacleList(place, place, t_ns, mission.UTC_NS + place * NS, t_ns, True, [], listed, made_ns=t_ns)
        collecting.add(Found(place, t_ns, mission.UTC_NS + place * NS, t_ns, [], mission.DETECTIONS, 1.0), reported)
    return collecting.result(Beside([mission.POSE], {}, AT_ORIGIN, ()), Counter())


ONE: dict[int, TrackState] = {2: AWAKE, 3: AWAKE, 4: AWAKE, 5: "stand_by", 6: "stand_by", 7: ASLEEP}


def test_states_of_a_life_follow_each_other_without_gaps() -> None:
    (strip,) = observer_times.strips(tracked({4: ONE}), 4)
    assert strip.marked
    assert list(strip.spans) == [
        ("tentative", 0.0, 2.0), ("active", 2.0, 5.0), ("stand_by", 5.0, 7.0), ("hibernated", 7.0, 7.0)
    ]  # fmt: skip


def test_a_life_that_the_lists_left_out_has_a_gap() -> None:
    (strip,) = observer_times.strips(tracked({4: dict.fromkeys((1, 2, 6), ASLEEP)}), None)
    assert list(strip.spans) == [("hibernated", 1.0, 2.0), ("hibernated", 6.0, 6.0)]


def test_a_curve_is_interrupted_where_the_lists_left_the_object_out() -> None:
    result = tracked({4: dict.fromkeys((1, 2, 6, 7), AWAKE)})
    curve = observer_times.panels(result, result.course(4))[0].curves[0]
    assert curve.y.tolist() == pytest.approx([11.0, np.nan, 16.0, 17.0], nan_ok=True)


def test_strips_are_of_those_reported_of_most_often() -> None:
    many = tracked({i: dict.fromkeys(range(1 + i % 5), "active") for i in range(1, 30)})
    strips = observer_times.strips(many, 5)
    assert len(strips) == observer_times.MOST_STRIPS
    assert "5" in [strip.id for strip in strips]  # reported of once, but marked
    assert [int(strip.id) for strip in strips] == sorted(int(strip.id) for strip in strips)


def test_curves_are_the_tracks_values_with_two_sigma() -> None:
    result = tracked({4: ONE})
    panels = observer_times.panels(result, result.course(4))
    north, velocity = panels[0], panels[1]
    assert north.curves[0].y.tolist() == [12.0, 13.0, 14.0, 15.0, 16.0, 17.0]
    assert north.bands[0].high.tolist() == [16.0, 17.0, 18.0, 19.0, 20.0, 21.0]
    assert velocity.curves[0].y.tolist() == [1.0] * 6
    assert velocity.bands[0].low.tolist() == pytest.approx([0.8] * 6)
    assert panels[-1].title == "probability of existence"  # no truth, no GOSPA


def test_an_ellipse_is_that_of_its_covariance() -> None:
    """Points of it are two standard deviations away by Mahalanobis' distance."""
    ellipse = observer_plan.ellipse_of((0.0, 0.0), 2.0, 1.0, 0.5)
    inverse = np.linalg.inv([[4.0, 0.5], [0.5, 1.0]])
    turn = ellipse.turn_rad
    for axis, angle in zip(ellipse.semi_m, (turn, turn + math.pi / 2), strict=True):
        point = axis * np.array([math.cos(angle), math.sin(angle)])
        assert math.sqrt(point @ inverse @ point) == pytest.approx(2.0, rel=1e-3)


def test_the_closest_approach_lies_where_both_will_be() -> None:
    result = tracked({4: ONE})
    shapes = observer_plan.moment(result, 3, 4)
    (line,) = [each for each in shapes if isinstance(each, Line) and each.role == "approach"]
    assert line.points[0] == (17.0, 5.0)  # 13 m north now, 4 s at 1 m/s
    assert line.points[1] == observer_plan.flat(result.path[3])  # which does not move
    assert line.label == "nearest to track 4: 3.0 ± 0.5 m in 4 s"


def test_a_marked_object_has_its_predictions() -> None:
    result = tracked({4: ONE, 9: ONE})
    shapes = observer_plan.moment(result, 3, 9)
    circles = {each.id: each for each in shapes if isinstance(each, Circle)}
    assert (circles["4"].marked, circles["9"].marked) == (False, True)
    assert [each.at for each in shapes if isinstance(each, Ellipse) and each.role == "prediction"] == [(18.0, 5.0)]


def test_places_out_of_the_mission_show_nothing() -> None:
    assert observer_plan.moment(tracked({}), 99, None) == []
    assert observer_times.panels(tracked({}), None) == []
