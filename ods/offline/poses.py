"""The vehicle's poses in a recording, as messages: .npz has them at its pings, .s7k 20 times a second."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.frames.quaternion import conjugate, from_euler, product, rotated
from ods.base.geodesy import LocalFrame
from ods.messages import Pose, Quaternion
from ods.sonar_link.files.ping_sequence import PingSequence
from ods.sonar_link.files.s7k.recorded_poses import read_poses

SIGMA_POSITION_M = (0.1, 0.1, 0.1)
SIGMA_ATTITUDE_RAD = (0.002, 0.002, 0.005)
"""No file reports how good its poses are: these are those of the bench's simulated INS."""


class PoseTrack(NamedTuple):
    """Where the vehicle went."""

    poses: list[Pose]
    """In order of time; `t_ns` and `utc_ns` are UTC, as those of the pings."""
    frame: LocalFrame | None
    """Frame of the positions; none: the file does not give the position of its origin."""


def pose_track_of(path: Path, recording: PingSequence, site: LocalFrame | None = None) -> PoseTrack:
    """Return the poses of a recording.

    site: the frame of positions; none: those of .s7k are relative to the first pose. Raises OdsError.
    """
    if recording.position_ned is not None and recording.attitude is not None and recording.timed:
        times = [ping.utc_ns for ping in recording.pings]
        attitudes: list[Quaternion] = [(w, x, y, z) for w, x, y, z in recording.attitude.tolist()]
        return PoseTrack(poses_along(times, recording.position_ned, attitudes), site)
    try:
        poses = read_poses(path)
    except OSError as error:
        raise OdsError(f"{path}: {error.strerror}") from error
    if not poses:
        raise OdsError(f"{path}: no poses in it: .s7k of `ods record`, or .npz with pos_ned and quat, has them")
    latitude, longitude, height, *_ = np.array([pose for _, pose in poses]).T
    latitude, longitude = np.degrees(latitude), np.degrees(longitude)
    frame = LocalFrame(float(latitude[0]), float(longitude[0])) if site is None else site
    attitudes = [
        product(frame.turn(*place), from_euler(pose.roll_rad, pose.pitch_rad, pose.heading_rad))
        for place, (_, pose) in zip(zip(latitude.tolist(), longitude.tolist(), strict=True), poses, strict=True)
    ]
    return PoseTrack(poses_along([t_ns for t_ns, _ in poses], frame.ned(latitude, longitude, height), attitudes), frame)


def poses_along(
    t_ns: Sequence[int], position_ned: Floats, attitude: Sequence[Quaternion], utc_ahead_ns: int = 0
) -> list[Pose]:
    """Return poses at rising times, (n,) ns, and places, (n, 3) m; velocities are those from place to place."""
    if len(t_ns) > 1:
        velocity = np.gradient(position_ned, (np.array(t_ns) - t_ns[0]) / NS, axis=0)
    else:
        velocity = np.zeros_like(position_ned)
    rows = zip(t_ns, position_ned.tolist(), attitude, velocity.tolist(), strict=True)
    return [
        Pose(
            number,
            t,
            t + utc_ahead_ns,
            tuple(place),
            turn,
            rotated(conjugate(turn), tuple(speed)),
            SIGMA_POSITION_M,
            SIGMA_ATTITUDE_RAD,
        )
        for number, (t, place, turn, speed) in enumerate(rows)
    ]
