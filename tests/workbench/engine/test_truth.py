"""Detections against the truth, by hand and on figure 11."""

import math

import msgspec
import pytest

from ods.base.files.shipped import shipped_file
from ods.base.frames.mounting import AT_ORIGIN, Mounting, MountingSettings
from ods.messages import Detections, Truth, TruthObject
from ods.offline.source import scene_source
from ods.workbench.engine.ping.truth import Judged, TrueCircle, judged, true_circles
from ods.workbench.engine.printing import detections_of
from ods.workbench.model.state import State, Tuning
from tests.export import mission
from tests.workbench.engine.test_compare import found


def reported(*circles: tuple[float, float, float], processed: list[tuple[float, float]] | None = None) -> Detections:
    """Return a ping's detections: range, bearing, radius of each."""
    return msgspec.structs.replace(
        mission.DETECTIONS, detections=[found(*each) for each in circles], processed_ranges_m=processed or []
    )


def true(range_m: float, bearing_rad: float, radius_m: float = 1.0, in_sector: bool = True) -> TrueCircle:
    return TrueCircle("rock", range_m, bearing_rad, radius_m, in_sector)


def test_each_object_has_one_detection_the_nearest_and_the_rest_is_false_or_missed() -> None:
    detections = reported((20.0, 0.0, 0.5), (20.9, 0.0, 0.5), (30.0, 0.3, 0.5), (21.6, 0.0, 0.5))
    objects = [true(20.8, 0.0), true(50.0, -0.2), true(60.0, 1.5, in_sector=False)]
    assert judged(detections, objects) == Judged(right=[(1, 0)], more=[0, 3], false=[2], missed=[1])


def test_two_objects_do_not_share_a_detection() -> None:
    assert judged(reported((20.0, 0.0, 2.0)), [true(19.0, 0.0), true(20.5, 0.0)]) == Judged([(0, 1)], [], [], [0])


def test_what_was_not_looked_at_is_not_missed() -> None:
    objects = [true(20.0, 0.0), true(40.0, 0.0)]
    assert judged(reported(processed=[(1.0, 30.0)]), objects) == Judged([], [], [], [0])
    assert judged(reported(processed=[(1.0, 30.0), (35.0, 50.0)]), objects).missed == [0, 1]


def test_nothing_against_nothing() -> None:
    assert judged(reported(), []) == Judged([], [], [], [])
    assert judged(reported((9.0, 0.0, 1.0)), []).false == [0]


def test_true_objects_lie_where_the_head_sees_them() -> None:
    """The vehicle heads east at (100, 20, 10); the object is 40 m east and 30 m south: to starboard."""
    object_ = TruthObject("rock", (70.0, 60.0, 10.0), (0.0, 0.0, 0.0), 1.5, True)
    truth = Truth(3, 0, 0, mission.POSE.position_ned, mission.POSE.attitude, [object_])
    (seen,) = true_circles(truth, AT_ORIGIN)
    assert (seen.range_m, seen.bearing_rad) == pytest.approx((50.0, math.atan(0.75)))
    assert (seen.name, seen.radius_m, seen.in_sector) == ("rock", 1.5, True)
    ahead = Mounting(MountingSettings(position_m=(40.0, 0.0, 0.0), yaw_deg=90.0))
    (seen,) = true_circles(truth, ahead)
    assert (seen.range_m, seen.bearing_rad) == pytest.approx((30.0, 0.0), abs=1e-9)
    assert true_circles(msgspec.structs.replace(truth, objects=[]), AT_ORIGIN) == []


def test_figure_11_is_found_as_it_is_and_with_a_high_level_missed() -> None:
    source = scene_source(shipped_file("scenes/figure11.toml"), "seabat6012")
    ping = source.pings[3]
    objects = true_circles(source.truths[ping.ping_number], AT_ORIGIN)
    right = judged(detections_of(ping, State().tuning), objects)
    assert sorted(objects[place].name for _, place in right.right) == ["far", "near", "port"]
    assert (right.false, right.missed) == ([], [])
    stage = {"use": "detect.two_level", "high": 100.0, "low": 50.0, "follow": 0.0}
    config = msgspec.convert({"pipeline": {"stage": [stage]}}, type(State().tuning.config))
    assert len(judged(detections_of(ping, Tuning(config=config)), objects).missed) == 3
