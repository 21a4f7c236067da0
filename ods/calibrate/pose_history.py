"""The vehicle's pose at any instant of a recording."""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from ods.base.arrays import Floats, Mask
from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.geodesy import LocalFrame
from ods.offline.poses import way_of
from ods.sonar_link.files.ping_sequence import PingSequence

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
    poses, _ = way_of(path, recording, frame)
    t_ns = np.array([pose.t_ns for pose in poses])
    attitude = Rotation.from_quat([pose.attitude for pose in poses], scalar_first=True)
    return PoseHistory((t_ns - t_ns[0]) / NS, np.array([pose.position_ned for pose in poses]), attitude), int(t_ns[0])
