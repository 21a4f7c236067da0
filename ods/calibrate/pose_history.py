"""The vehicle's pose at any instant of a recording."""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from ods.base.arrays import Floats, Mask
from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.geodesy import LocalFrame
from ods.sonar_link.files.ping_sequence import PingSequence
from ods.sonar_link.files.s7k.recorded_poses import read_poses

LONGEST_GAP_S = 0.4
"""Between two poses: no instant in between is used. Poses of a .npz stand at the pings, 0.27 s apart at 200 m."""


class PoseHistory:
    """Poses in order of time, interpolated."""

    def __init__(self, t_s: Floats, position_ned: Floats, attitude: Rotation) -> None:
        """`t_s`: (n,) rising, `position_ned`: (n, 3) m, `attitude`: n rotations, body to global. Raises OdsError."""
        if len(t_s) < 2 or not (np.diff(t_s) > 0.0).all():
            raise OdsError("the recording has no poses, or their times do not rise")
        self._t_s, self._position = t_s, position_ned
        self._slerp = Slerp(t_s, attitude)

    def at(self, t_s: Floats) -> tuple[Floats, Rotation]:
        """Return (k, 3) places, m, and k attitudes at times (k,); before and after the recording those of its ends."""
        inside = np.clip(t_s, self._t_s[0], self._t_s[-1])
        place = np.column_stack([np.interp(inside, self._t_s, column) for column in self._position.T])
        return place, self._slerp(inside)

    def knows(self, t_s: Floats, margin_s: float) -> Mask:
        """Tell (k,) at which times poses are known, and all around them up to `margin_s`."""
        known = (t_s >= self._t_s[0] + margin_s) & (t_s <= self._t_s[-1] - margin_s)
        for gap in np.flatnonzero(np.diff(self._t_s) > LONGEST_GAP_S):
            known &= (t_s < self._t_s[gap] - margin_s) | (t_s > self._t_s[gap + 1] + margin_s)
        return np.asarray(known)


def history_of(path: Path, recording: PingSequence, frame: LocalFrame) -> tuple[PoseHistory, int]:
    """Return the poses of a recording, in the frame of the site, and the UTC, ns, of time 0. Raises OdsError."""
    if recording.position_ned is not None and recording.attitude is not None and recording.timed:
        t_ns = np.array([ping.utc_ns for ping in recording.pings])
        attitude = Rotation.from_quat(recording.attitude, scalar_first=True)
        return PoseHistory((t_ns - t_ns[0]) / NS, recording.position_ned, attitude), int(t_ns[0])
    try:
        poses = read_poses(path)
    except OSError as error:
        raise OdsError(f"{path}: {error.strerror}") from error
    if not poses:
        raise OdsError(f"{path}: no poses in it: .s7k of `ods record`, or .npz with pos_ned and quat, has them")
    t_ns = np.array([told for told, _ in poses])
    latitude, longitude, height, roll, pitch, heading = np.array([pose for _, pose in poses]).T
    there = np.degrees(latitude), np.degrees(longitude)
    turns = Rotation.from_quat([frame.turn(*place) for place in zip(*there, strict=True)], scalar_first=True)
    attitude = turns * Rotation.from_euler("ZYX", np.column_stack([heading, pitch, roll]))
    return PoseHistory((t_ns - t_ns[0]) / NS, frame.ned(*there, height), attitude), int(t_ns[0])
