"""Repeated images: the sonar hangs, and its image is wrong once the vehicle moves.

The receiver's noise is another one in each ping, and so is the speckle of what the vehicle has moved past. So an image
is recognized by the signs of 1024 differences between neighbouring samples: what shows nearly all of them again is the
same image, whatever a counter or a clock in it says. It is held against those of the last pings, as a sonar may go
through its buffers in turn.
"""

import math
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Ints
from ods.base.clock import NS
from ods.base.frames.quaternion import turn_between
from ods.compiled import native
from ods.messages import Ping, Pose, frame_of
from ods.pipeline.prepared.plan import PingError

REMEMBERED = 32
"""Pings."""
ALIKE = 0.9
"""Correlation of the signs of two images that are the same. A static scene whose echoes are less than 20 dB over the
noise has less."""
STILL_S = 1.0
"""Time for which an image must stay the same to be reported, s."""
MOVED_M, TURNED_RAD = 1.0, math.radians(5.0)
"""Distance and turn of the vehicle from which on an unchanged image is rejected: a stationary vehicle may see one."""
_WORDS = 32


@dataclass(slots=True, eq=False)
class _Image:
    """One that came for the first time."""

    signs: Ints
    t_ns: int
    pose: Pose | None
    """The newest one of the vehicle then, or the first one that was received."""


class RepeatedImage:
    """Compares each image with those before, and the vehicle with where it was then."""

    def __init__(self) -> None:
        self._images: list[_Image] = []
        """Of each of the last pings, in turn, the first image that was like its,"""
        self._known = np.zeros((REMEMBERED, _WORDS), np.int64)
        """and its signs."""
        self._pings = 0
        self._newest: Pose | None = None

    def add_pose(self, pose: Pose) -> None:
        """Take in a pose."""
        self._newest = pose

    def judge(self, ping: Ping) -> str:
        """Return what makes the image doubtful, in plain words; "": nothing.

        Raises PingError for one that cannot be of now. One that shows nothing is no concern of this.
        """
        try:
            frame = frame_of(ping)
        except ValueError as error:
            raise PingError(str(error)) from error
        signs = np.empty(_WORDS, np.int64)
        alike = native.find_alike(frame, self._known, ALIKE, signs)
        image = _Image(signs, ping.t_ns, self._newest) if alike < 0 else self._images[alike]
        self._remember(image)
        if alike < 0:
            return ""
        image.pose = image.pose or self._newest
        since_s, newest = (ping.t_ns - image.t_ns) / NS, self._newest
        if image.pose is not None and newest is not None:
            moved_m = math.dist(image.pose.position_ned, newest.position_ned)
            turned = turn_between(image.pose.attitude, newest.attitude)
            if moved_m > MOVED_M or turned > TURNED_RAD:
                motion = f"moved by {moved_m:.1f} m and turned by {math.degrees(turned):.0f} deg"
                raise PingError(
                    f"the image is identical to an earlier one although the vehicle has {motion}: the sonar hangs"
                )
        return f"the image has not changed for {since_s:.1f} s" if since_s >= STILL_S else ""

    def _remember(self, image: _Image) -> None:
        place = self._pings % REMEMBERED
        self._images[place : place + 1] = [image]
        self._known[place] = image.signs
        self._pings += 1
