"""An image that comes again and again while the vehicle moves: the sonar hangs, and what it shows is elsewhere."""

import math

from ods.messages import Ping, Pose
from ods.pipeline.plan import PingError
from ods.runtime.turn import turn_between

MOVED_M, TURNED_RAD = 1.0, math.radians(5.0)
"""So far a vehicle moves, or turns, before an image that is the same to the byte is not believed any more: noise and
speckle alone make no two images alike, but a sonar of someone's test, with a vehicle at rest, may."""


class FrozenImage:
    """Compares each image with the one before, and the vehicle with where it was then."""

    def __init__(self) -> None:
        self._data = b""
        self._begun: Pose | None = None
        """The vehicle's pose when this image came first."""
        self._newest: Pose | None = None

    def hear_pose(self, pose: Pose) -> None:
        """Take in a pose."""
        self._newest = pose

    def refuse(self, ping: Ping) -> None:
        """Raises PingError for an image that cannot be of now. One that shows nothing is no concern of this."""
        begun, newest = self._begun, self._newest
        if ping.data != self._data or begun is None or newest is None:
            self._data, self._begun = ping.data, newest
            return
        moved_m, turned = math.dist(begun.position_ned, newest.position_ned), turn_between(begun, newest)
        if (moved_m > MOVED_M or turned > TURNED_RAD) and _shows_something(ping):
            motion = f"moved by {moved_m:.1f} m and turned by {math.degrees(turned):.0f} deg"
            raise PingError(f"its image is the same to the byte since the vehicle has {motion}: the sonar hangs")


def _shows_something(ping: Ping) -> bool:
    size = int(ping.dtype[1])
    return ping.data != ping.data[:size] * (len(ping.data) // size)
