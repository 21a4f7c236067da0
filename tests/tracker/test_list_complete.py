"""One list is enough on another machine: where the frame is, from where it was seen, what was looked at, and when."""

import math

import msgspec
import pytest

from ods.base.clock import NS
from ods.base.frames.mounting import MountingSettings
from ods.base.geodesy import SiteSettings
from ods.messages import Detections, ObstacleList, Pose, Sector, Site
from ods.pose.buffer import PoseSettings
from ods.pose.utc import VehicleUtc
from ods.tracker.mission import MissionTracker
from ods.tracker.output.validity import InputMonitor
from ods.tracker.settings import TrackerConfig, TrackerSettings

SECTOR = Sector(1.0, 80.0, -0.7, 0.7, 0.15)
UTC_AHEAD_NS = 1_790_000_000 * NS
CONFIG = TrackerConfig(
    site=SiteSettings(latitude_deg=57.5, longitude_deg=10.25),
    pose=PoseSettings(),
    tracker=TrackerSettings(),
    mounting=MountingSettings(position_m=(2.0, 0.0, 0.5), yaw_deg=90.0),
)


def mission() -> MissionTracker:
    return MissionTracker(CONFIG, InputMonitor(0, (), lambda _: ""), VehicleUtc(0, UTC_AHEAD_NS, "clock"))


def reported(tracker: MissionTracker, t_ns: int, made_ns: int) -> ObstacleList:
    """Return the list of a ping sent at `t_ns`, half-way between two poses of a vehicle that goes east at 2 m/s."""
    east = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
    for seq, off_ns in enumerate((-NS // 20, NS // 20)):
        place = (10.0, 20.0 + 2.0 * off_ns / NS, 5.0)
        at_ns = t_ns + off_ns
        pose = Pose(seq, at_ns, at_ns + UTC_AHEAD_NS, place, east, (2.0, 0.0, 0.0), (0.1, 0.2, 0.3), (0.01, 0.02, 0.03))
        tracker.add_pose(pose)
    rings = [(1.0, 50.0), (60.0, 80.0)]
    message = Detections(0, 0, t_ns, t_ns, t_ns, 1500.0, SECTOR, [], processed_ranges_m=rings)
    answer = tracker.track(message, made_ns)
    assert answer is not None
    return answer.message


def test_the_list_tells_all_that_a_planner_elsewhere_needs() -> None:
    picture = reported(mission(), 5 * NS, 5 * NS + 70_000_000)
    assert picture.frame == "ned"
    assert picture.site == Site(57.5, 10.25)
    assert picture.sector == SECTOR
    assert picture.processed_ranges_m == [(1.0, 50.0), (60.0, 80.0)]
    assert picture.utc_ns == picture.t_ns + UTC_AHEAD_NS
    assert picture.made_utc_ns == picture.made_ns + UTC_AHEAD_NS
    pose, head = picture.pose, picture.head
    assert pose is not None
    assert head is not None
    assert pose.position_ned == pytest.approx((10.0, 20.0, 5.0))
    assert pose.velocity_ned == pytest.approx((0.0, 2.0, 0.0))
    assert (pose.sigma_position, pose.sigma_attitude) == ((0.1, 0.2, 0.3), (0.01, 0.02, 0.03))
    assert pose.extrapolated_s == 0.0
    assert head.position_ned == pytest.approx((10.0, 22.0, 5.5))
    assert [abs(part) for part in head.attitude] == pytest.approx([0.0, 0.0, 0.0, 1.0])  # it looks south


def test_what_is_not_known_is_none() -> None:
    picture = mission().silent_list(9 * NS)
    assert (picture.pose, picture.head, picture.sector, picture.processed_ranges_m) == (None, None, None, [])
    assert picture.site == Site(57.5, 10.25)


def test_lists_of_before_are_still_read_and_new_ones_by_readers_of_before() -> None:
    picture = reported(mission(), 5 * NS, 5 * NS)
    raw = msgspec.msgpack.decode(msgspec.msgpack.encode(picture))
    for name in ("made_utc_ns", "frame", "site", "pose", "head", "sector", "processed_ranges_m"):
        del raw[name]
    old = msgspec.msgpack.decode(msgspec.msgpack.encode(raw), type=ObstacleList)
    assert (old.site, old.pose, old.made_utc_ns, old.obstacles) == (None, None, 0, picture.obstacles)
