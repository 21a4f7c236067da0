"""The vehicle's pose at any instant of a recording."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from ods.base.arrays import Floats, Mask
from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.messages import Pose

LONGEST_GAP_S = 0.4
"""Between two poses: no instant in between is used. Poses of a .npz stand at the pings, 0.27 s apart at 200 m."""


class PoseHistory:
    """Poses in order of time, interpolated."""

    def __init__(self, t_s: Floats, position_ned: Floats, attitude: Rotation) -> None:
        """`t_s`: (n,) rising, `position_ned`: (n, 3) m, `attitude`: n rotations, body to global. Raises OdsError."""
        if len(t_s) < 2 or not (np.diff(t_s) > 0.0).all():
            raise OdsError("the recording has no poses, or their times do not increase")
        self._t_s, self._position = t_s, position_ned
        self._slerp = Slerp(t_s, attitude)

    def at(self, t_s: Floats) -> tuple[Floats, Rotation]:
        """Return (k, 3) places, m, and k attitudes at times (k,); before and after the recording those of its ends."""
        inside = np.clip(t_s, self._t_s[0], self._t_s[-1])
        place = np.column_stack([np.interp(inside, self._t_s, column) for column in self._position.T])
        return place, self._slerp(inside)

    def knows(self, t_s: Floats, margin_s: float) -> Mask:
        """Return (k,) bool: times at which, and within `margin_s` of which, poses are known."""
        known = (t_s >= self._t_s[0] + margin_s) & (t_s <= self._t_s[-1] - margin_s)
        for gap in np.flatnonzero(np.diff(self._t_s) > LONGEST_GAP_S):
            known &= (t_s < self._t_s[gap] - margin_s) | (t_s > self._t_s[gap + 1] + margin_s)
        return np.asarray(known)


def history_of(poses: Sequence[Pose]) -> tuple[PoseHistory, int]:
    """Return the poses, in order of time, and the `t_ns` of time 0. One that comes twice is one. Raises OdsError."""
    by_time = {pose.t_ns: pose for pose in poses}
    if not by_time:
        raise OdsError("the recording has no poses")
    t_ns = np.array(list(by_time))
    attitude = Rotation.from_quat([pose.attitude for pose in by_time.values()], scalar_first=True)
    places = np.array([pose.position_ned for pose in by_time.values()])
    return PoseHistory((t_ns - t_ns[0]) / NS, places, attitude), int(t_ns[0])
