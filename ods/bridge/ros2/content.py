"""Contents of each topic for a list at one instant: pure, without DDS."""

from collections.abc import Callable
from typing import Any

import msgspec

from ods.base.frames import quaternion
from ods.bridge.extrapolated_list import ExtrapolatedList
from ods.messages import ObstacleList, Pose, PoseAt
from ods.ros2 import enu
from ods.ros2.markers import markers
from ods.ros2.messages import ERROR, OK, STALE, WARN, Messages
from ods.ros2.tracks import tracks

NAME = "ods: obstacles"


def now(extrapolated: ExtrapolatedList, most: int) -> ObstacleList:
    """Return the list with the nearest obstacles, and the vehicle, where they are at the instant of sending."""
    there = [msgspec.structs.replace(o, position_ned=extrapolated.place(o)) for o in extrapolated.nearest(most)]
    pose = msgspec.structs.replace(extrapolated.pose, position_ned=extrapolated.vehicle())
    return msgspec.structs.replace(extrapolated.obstacle_list, obstacles=there, pose=pose)


def heeded(obstacle_list: ObstacleList) -> ObstacleList:
    """Return the list without vetoed obstacles, for messages that cannot mark them."""
    kept = [each for each in obstacle_list.obstacles if each.ignored_by < 0]
    return (
        obstacle_list
        if len(kept) == len(obstacle_list.obstacles)
        else msgspec.structs.replace(obstacle_list, obstacles=kept)
    )


def odometry(make: Messages, stamp_ns: int, obstacle_list: ObstacleList) -> Any:
    """Return the vehicle's pose and velocity."""
    pose = obstacle_list.pose
    assert pose is not None
    velocity_body = quaternion.rotated(quaternion.conjugate(pose.attitude), pose.velocity_ned)
    vehicle = Pose(
        obstacle_list.seq, obstacle_list.t_ns, stamp_ns, pose.position_ned, pose.attitude, velocity_body,
        pose.sigma_position, pose.sigma_attitude,
    )  # fmt: skip
    return make.odometry(stamp_ns, vehicle)


def transforms(make: Messages, stamp_ns: int, obstacle_list: ObstacleList) -> Any:
    """Return the vehicle in the map, and the sonar's head and fan on the vehicle where the head's place is known."""
    pose, frames = obstacle_list.pose, make.frames
    assert pose is not None
    transforms = [
        make.transform(stamp_ns, (frames.map, frames.vehicle), enu.enu(pose.position_ned), enu.attitude(pose.attitude))
    ]
    if obstacle_list.head is not None:
        transforms += [_head(make, stamp_ns, pose, obstacle_list.head), make.fan(stamp_ns)]
    return make.new("tf2_msgs/msg/TFMessage", transforms)


def _head(make: Messages, stamp_ns: int, pose: PoseAt, head: PoseAt) -> Any:
    back = quaternion.conjugate(pose.attitude)
    north, east, down = (there - own for there, own in zip(head.position_ned, pose.position_ned, strict=True))
    lever = quaternion.rotated(back, (north, east, down))
    turn = enu.mounting(quaternion.product(back, head.attitude))
    return make.transform(stamp_ns, (make.frames.vehicle, make.frames.head), enu.flu(lever), turn)


OF_LISTS: dict[str, Callable[[Messages, int, ObstacleList], Any]] = {
    "obstacles": lambda make, stamp_ns, obstacle_list: make.obstacles(stamp_ns, heeded(obstacle_list)),
    "markers": markers,
    "tracks": lambda make, stamp_ns, obstacle_list: tracks(make, stamp_ns, heeded(obstacle_list)),
    "odometry": odometry,
    "tf": transforms,
}
"""By the topic's key."""


def verdict(make: Messages, stamp_ns: int, newest: ObstacleList | None, silent: str, age_s: float) -> Any:
    """Return whether lists are sent, and why not."""
    if newest is None:
        return make.diagnostic(stamp_ns, NAME, STALE, silent, {})
    level = ERROR if silent else WARN if newest.caution else OK
    values = {
        "valid": newest.valid, "seq": newest.seq, "ping_number": newest.ping_number, "age_s": f"{age_s:.3f}",
        "left_out": newest.left_out, "utc_source": newest.utc_source, "unseen_share": f"{newest.unseen_share:.3f}",
    }  # fmt: skip
    return make.diagnostic(stamp_ns, NAME, level, silent or newest.caution or "valid", values)
