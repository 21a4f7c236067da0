"""The vehicle's pose at any recent instant, from the poses received: interpolation, short extrapolation, or none."""

import math
from bisect import bisect_left
from collections import Counter
from dataclasses import dataclass
from typing import Annotated

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.quaternion import rotated, slerp
from ods.base.settings import Positive, Settings, slider
from ods.messages import Pose, Quaternion, Vector3

TURN_BASE_NS = NS // 10
"""Time over which the rate of turn is taken for extrapolation."""
POSITION_GROWTH = 0.2
"""Standard deviation that extrapolation adds to each coordinate, m/s."""
ATTITUDE_GROWTH = 0.1
"""Standard deviation that extrapolation adds to roll, pitch and yaw, rad/s."""
NORM_TOLERANCE = 1e-3


class PoseSettings(Settings, frozen=True):
    """Poses that pipeline and tracker keep."""

    capacity: Annotated[int, msgspec.Meta(ge=2)] = 400
    """Must reach back to a ping's transmission."""
    max_extrapolation_s: Annotated[Positive, slider(0.05, 2.0, unit="s")] = 0.3
    """Longest extrapolation, and longest gap interpolated."""
    max_rate_hz: Positive = 250.0
    """Poses kept of each second, beside the newest."""


@dataclass(frozen=True, slots=True)
class PoseEstimate:
    """The pose at one instant. Attitude is w, x, y, z, body to global."""

    t_ns: int
    position_ned: Floats
    """(3,) m."""
    attitude: Floats
    """(4,)."""
    velocity_ned: Floats
    """(3,) m/s."""
    sigma_position: Floats
    """(3,) standard deviations north, east, down, m."""
    sigma_attitude: Floats
    """(3,) standard deviations of roll, pitch, yaw, rad."""
    extrapolated_s: float
    """Time to the pose it was extrapolated from; 0 when it lies between two poses."""
    altitude_m: float | None = None
    """Over the bottom, none: not known;"""
    sigma_altitude_m: float = 0.0
    """and its standard deviation."""


class PoseBuffer:
    """The last `capacity` poses, in order of time whatever the order they came in.

    `counters`: `pose_bad` (not finite, attitude no unit quaternion, negative sigma), `pose_duplicate` (its instant is
    known), `pose_too_old` (older than all of a full buffer), `pose_thinned` (others are so near in time that it is of
    no use).
    """

    def __init__(self, capacity: int, max_extrapolation_s: float, max_rate_hz: float = math.inf) -> None:
        """See `PoseSettings`."""
        self.counters: Counter[str] = Counter()
        self._capacity = capacity
        self._limit_ns = round(max_extrapolation_s * NS)
        self._spacing_ns = NS / max_rate_hz
        self._times: list[int] = []
        self._poses: list[Pose] = []

    def __len__(self) -> int:
        return len(self._times)

    def insert(self, pose: Pose) -> None:
        """Take a pose in; a bad one, one of a known instant and one too old to be kept are counted and dropped."""
        if not _is_sound(pose):
            self.counters["pose_bad"] += 1
            return
        place = bisect_left(self._times, pose.t_ns)
        if place < len(self._times) and self._times[place] == pose.t_ns:
            self.counters["pose_duplicate"] += 1
            return
        if self._thins(place, pose):
            self.counters["pose_thinned"] += 1
            return
        if len(self._times) == self._capacity:
            if place == 0:
                self.counters["pose_too_old"] += 1
                return
            del self._times[0], self._poses[0]
            place -= 1
        self._times.insert(place, pose.t_ns)
        self._poses.insert(place, pose)

    def _thins(self, place: int, pose: Pose) -> bool:
        """Return whether a pose is of no use at `place`; a newest one replaces the one before if that is of none."""
        times = self._times
        if place < len(times):
            earlier_ns = times[place - 1] if place else pose.t_ns - self._spacing_ns
            return times[place] - earlier_ns < self._spacing_ns
        if len(times) < 2 or times[-1] - times[-2] >= self._spacing_ns:
            return False
        times[-1], self._poses[-1] = pose.t_ns, pose
        return True

    def at(self, t_ns: int) -> PoseEstimate | None:
        """Return the pose at `t_ns`, or None when no pose is near enough.

        Between two poses it is interpolated. Outside, and in a gap longer than the extrapolation limit, the nearest
        pose is extrapolated at its velocity and, ahead in time, its rate of turn, with growing uncertainty.
        """
        times = self._times
        after = bisect_left(times, t_ns)
        if after == len(times):
            return self._extrapolate(after - 1, t_ns) if times else None
        if after == 0:
            return self._extrapolate(0, t_ns)
        before_ns, after_ns = times[after - 1], times[after]
        if t_ns == after_ns or after_ns - before_ns <= self._limit_ns:
            return self._interpolate(after, t_ns)
        nearest = after if after_ns - t_ns < t_ns - before_ns else after - 1
        return self._extrapolate(nearest, t_ns)

    def _interpolate(self, after: int, t_ns: int) -> PoseEstimate:
        a, b = self._poses[after - 1], self._poses[after]
        f = (t_ns - a.t_ns) / (b.t_ns - a.t_ns)
        attitude = slerp(a.attitude, b.attitude, f)
        return PoseEstimate(
            t_ns,
            np.array(_mix(a.position_ned, b.position_ned, f)),
            np.array(attitude),
            np.array(rotated(attitude, _mix(a.velocity_body, b.velocity_body, f))),
            np.array(_mix(a.sigma_position_ned, b.sigma_position_ned, f)),
            np.array(_mix(a.sigma_attitude, b.sigma_attitude, f)),
            0.0,
            *_altitude(a, b, f),
        )

    def _extrapolate(self, index: int, t_ns: int) -> PoseEstimate | None:
        pose = self._poses[index]
        if abs(t_ns - pose.t_ns) > self._limit_ns:
            return None
        dt = (t_ns - pose.t_ns) / NS
        velocity = rotated(pose.attitude, pose.velocity_body)
        return PoseEstimate(
            t_ns,
            np.array([p + v * dt for p, v in zip(pose.position_ned, velocity, strict=True)]),
            np.array(self._turned(index, t_ns)),
            np.array(velocity),
            np.array([math.hypot(s, POSITION_GROWTH * dt) for s in pose.sigma_position_ned]),
            np.array([math.hypot(s, ATTITUDE_GROWTH * dt) for s in pose.sigma_attitude]),
            abs(dt),
            None if pose.altitude_m is None else max(pose.altitude_m - velocity[2] * dt, 0.0),
            math.hypot(pose.sigma_altitude_m, POSITION_GROWTH * dt),
        )

    def _turned(self, index: int, t_ns: int) -> Quaternion:
        """Return the attitude of pose `index`, turned on at its recent rate when `t_ns` is later."""
        pose = self._poses[index]
        base = bisect_left(self._times, pose.t_ns - TURN_BASE_NS)
        if t_ns <= pose.t_ns or base >= index:
            return pose.attitude
        earlier = self._poses[base]
        return slerp(earlier.attitude, pose.attitude, (t_ns - earlier.t_ns) / (pose.t_ns - earlier.t_ns))


def _is_sound(pose: Pose) -> bool:
    sigmas = (*pose.sigma_position_ned, *pose.sigma_attitude, pose.sigma_altitude_m)
    numbers = (*pose.position_ned, *pose.velocity_body, *pose.attitude, *sigmas, pose.altitude_m or 0.0)
    return (
        math.isfinite(sum(numbers)) and abs(math.hypot(*pose.attitude) - 1.0) <= NORM_TOLERANCE and min(sigmas) >= 0.0
    )


def _altitude(a: Pose, b: Pose, f: float) -> tuple[float | None, float]:
    """Return the altitude between two poses and its standard deviation; known where both know it."""
    if a.altitude_m is None or b.altitude_m is None:
        return None, 0.0
    return (
        a.altitude_m + f * (b.altitude_m - a.altitude_m),
        a.sigma_altitude_m + f * (b.sigma_altitude_m - a.sigma_altitude_m),
    )


# Plain floats: for three or four numbers they are five times faster than numpy.


def _mix(a: Vector3, b: Vector3, f: float) -> Vector3:
    return a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]), a[2] + f * (b[2] - a[2])
