"""What the bridge to ROS 2 says of a list: places of now, and frames, computed by hand."""

import math
from typing import Any

import numpy as np
import pytest

from ods.base.clock import NS
from ods.bridge.ros2 import content
from ods.messages import PoseAt
from ods.ros2.messages import ERROR, OK, STALE, UNKNOWN, WARN, Messages
from tests.bridge.samples import ENDED, ROCK, SWIMMER, UTC_NS, moment, obstacle_list

MAKE = Messages()
NOW_NS = UTC_NS + NS


def xyz(v: Any) -> tuple[float, ...]:
    return v.x, v.y, v.z


def xyzw(v: Any) -> tuple[float, ...]:
    return v.x, v.y, v.z, v.w


def test_places_are_those_of_the_instant_of_sending() -> None:
    told = content.now(moment(SWIMMER, ENDED, ROCK), 10)  # a second after its ping
    assert [each.id for each in told.obstacles] == [7, 300]
    assert told.obstacles[1].position_ned == (110.0, 88.0, 5.0)
    assert told.pose is not None
    assert told.pose.position_ned == (100.0, 21.0, 5.0)
    assert [each.id for each in content.now(moment(SWIMMER, ROCK), 1).obstacles] == [7]


def test_odometry() -> None:
    # to the east at 2 m/s on a heading of east: ahead in the vehicle, no turn in ENU
    made = content.odometry(MAKE, NOW_NS, content.now(moment(ROCK), 10))
    assert (made.header.frame_id, made.child_frame_id) == ("map", "base_link")
    assert made.header.stamp.sec * NS + made.header.stamp.nanosec == NOW_NS
    assert xyz(made.pose.pose.position) == (21.0, 100.0, -5.0)
    assert abs(made.pose.pose.orientation.w) == pytest.approx(1.0)
    assert xyz(made.twist.twist.linear) == pytest.approx((2.0, 0.0, 0.0))
    assert made.pose.covariance[0] == pytest.approx(0.01)
    assert made.pose.covariance[35] == pytest.approx(1e-4)
    assert made.twist.covariance.reshape(6, 6).tolist() == np.diag([UNKNOWN] * 6).tolist()


def test_frames() -> None:
    # the head is 1 m ahead and 0.5 m below the origin, and looks 90 deg to starboard: south, as the vehicle heads east
    south = (0.0, 0.0, 0.0, 1.0)
    head = PoseAt((100.0, 20.0, 5.5), south, (0.0, 2.0, 0.0), (0.1, 0.1, 0.1), (0.01, 0.01, 0.01))
    told = content.transforms(MAKE, NOW_NS, obstacle_list(ROCK, head=head)).transforms
    assert [(each.header.frame_id, each.child_frame_id) for each in told] == [
        ("map", "base_link"), ("base_link", "sonar"), ("sonar", "sonar_fan"),
    ]  # fmt: skip
    assert xyz(told[0].transform.translation) == (19.0, 100.0, -5.0)
    assert xyz(told[1].transform.translation) == pytest.approx((1.0, 0.0, -0.5))
    half = math.sqrt(0.5)
    assert xyzw(told[1].transform.rotation) == pytest.approx((0.0, 0.0, -half, half))  # to starboard is negative
    assert len(content.transforms(MAKE, NOW_NS, obstacle_list(ROCK)).transforms) == 1


def test_the_verdict() -> None:
    def said(*args: Any) -> tuple[int, str]:
        (status,) = content.verdict(MAKE, NOW_NS, *args).status
        return status.level, status.message

    assert said(obstacle_list(ROCK), "", 0.1) == (OK, "valid")
    assert said(obstacle_list(ROCK, caution="it does not change"), "", 0.1) == (WARN, "it does not change")
    assert said(obstacle_list(ROCK, valid=False), "the list is not valid: blind", 0.1) == (
        ERROR, "the list is not valid: blind",
    )  # fmt: skip
    assert said(None, "no obstacle list for 2.0 s", 0.0) == (STALE, "no obstacle list for 2.0 s")
