"""Expected measurement of a fixed object: by its place, the mounting and the latency."""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ods.base.arrays import Floats, Indices
from ods.base.frames.geometry import wrap_angle
from ods.base.frames.mounting import MountingSettings
from ods.calibrate.pose_history import PoseHistory


class Echoes(NamedTuple):
    """Detections of a recording: (n,) each."""

    ping: Indices
    t_s: Floats
    """When their pings are said to have been sent, s."""
    range_m: Floats
    bearing: Floats
    """rad."""
    elevation: Floats
    """Of the plane they were seen in, rad."""
    snr_db: Floats
    sigma_range: Floats
    sigma_bearing: Floats
    sound_speed: Floats

    def take(self, which: Indices) -> "Echoes":
        """Return some of them."""
        ping, *others = self
        return Echoes(ping[which], *(column[which] for column in others))


class Parameters(NamedTuple):
    """The estimated parameters, in this order."""

    north: float
    east: float
    down: float
    """The object, m."""
    yaw: float
    pitch: float
    """The head's, rad."""
    latency: float
    """By how much pings are said to be sent too late, s."""
    nearer: float
    """By how much the object's echo is nearer than its middle, m."""


class HeadPoses(NamedTuple):
    """Poses of the sonar's head: the vehicle's poses and the mounting."""

    history: PoseHistory
    mounting: MountingSettings

    def head(self, t_s: Floats, yaw: float, pitch: float) -> tuple[Floats, Rotation]:
        """Return the head's (k, 3) places and k attitudes at times (k,)."""
        place, body = self.history.at(t_s)
        turn = Rotation.from_euler("ZYX", [yaw, pitch, np.radians(self.mounting.roll_deg)])
        return place + body.apply(self.mounting.position_m), body * turn


def measurement_residuals(echoes: Echoes, head_poses: HeadPoses, parameters: Parameters) -> tuple[Floats, Floats]:
    """Return (n,) measured less expected range, m, and bearing, rad.

    The range is half the way from the head at transmission to the object and on to the head at reception; the bearing
    is that in the head's frame at reception.
    """
    sent_s = echoes.t_s - parameters.latency
    there, _ = head_poses.head(sent_s, parameters.yaw, parameters.pitch)
    back, turn = head_poses.head(sent_s + 2.0 * echoes.range_m / echoes.sound_speed, parameters.yaw, parameters.pitch)
    place = np.array(parameters[:3])
    seen = turn.inv().apply(place - back)
    way = 0.5 * (np.linalg.norm(place - there, axis=1) + np.linalg.norm(seen, axis=1))
    bearing = wrap_angle(echoes.bearing - np.arctan2(seen[:, 1], seen[:, 0]))
    return np.asarray(echoes.range_m - way + parameters.nearer), bearing


def places(echoes: Echoes, head_poses: HeadPoses, yaw: float, pitch: float) -> Floats:
    """Return the (n, 3) places where the echoes are, if heads look like that and nothing is late; level ones."""
    place, turn = head_poses.head(echoes.t_s + 2.0 * echoes.range_m / echoes.sound_speed, yaw, pitch)
    level = echoes.range_m * np.cos(echoes.elevation)
    seen = [level * np.cos(echoes.bearing), level * np.sin(echoes.bearing), -echoes.range_m * np.sin(echoes.elevation)]
    return np.asarray(place + turn.apply(np.column_stack(seen)))
