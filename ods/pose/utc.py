"""UTC as the tracker stamps with it: that of the poses, so that a list and the map have one.

A step of UTC (a clock that is set, an INS that begins to send it) changes no order in time and no age: what was stamped
since the tracker started moves with it, what is of earlier missions does not.
"""

from typing import NamedTuple

from ods.base.clock import NS
from ods.messages import Pose, UtcSource

STEP_NS = NS
"""A change of less is followed without a word."""


class Restamp(NamedTuple):
    """A step of UTC, and the stamps that it moves."""

    since_ns: int
    until_ns: int
    """By UTC as it was."""
    step_ns: int

    def of(self, utc_ns: int) -> int:
        """Return a stamp after the step."""
        return utc_ns + self.step_ns if self.since_ns <= utc_ns <= self.until_ns else utc_ns


class VehicleUtc:
    """UTC of instants of CLOCK_MONOTONIC."""

    def __init__(self, started_ns: int, ahead_ns: int, source: UtcSource) -> None:
        """Begin with this computer's clock, which is this far ahead of CLOCK_MONOTONIC."""
        self.source = source
        self.started_ns = started_ns
        self.ahead_ns = self._reported_ns = ahead_ns
        self._step_ns = 0
        """Of what came since the last `follow`, from pose to pose: so a replay finds the same step to the ns."""

    def receive(self, pose: Pose) -> None:
        """Take what the newest pose says of UTC."""
        before_ns, self._reported_ns, self.source = self._reported_ns, pose.utc_ns - pose.t_ns, pose.utc_source
        if abs(self._reported_ns - before_ns) >= STEP_NS:
            self._step_ns += self._reported_ns - before_ns

    def at(self, t_ns: int) -> int:
        """Return UTC of an instant, ns, as of the last `follow`."""
        return t_ns + self.ahead_ns

    def follow(self, now_ns: int) -> Restamp | None:
        """Take over what the poses say; return what that moves, None when it is no step."""
        before_ns, self.ahead_ns = self.ahead_ns, self._reported_ns
        step_ns, self._step_ns = self._step_ns, 0
        if not step_ns:
            return None
        return Restamp(self.started_ns + before_ns, now_ns + before_ns, step_ns)
