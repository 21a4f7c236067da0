"""Plausibility of poses: jumps of position and attitude, a place that stands still under way, an attitude not known;
and
places that do not move as the velocity reports.

An INS that hangs, or that takes its first fix after a dive, sends poses of which each alone is believable. Objects seen
before a jump lie elsewhere for the poses after it.
"""

import math
from collections import deque

from ods.base.clock import NS
from ods.base.frames.quaternion import rotated, turn_between
from ods.messages import Pose
from ods.pose.buffer import NORM_TOLERANCE
from ods.pose.motion import PoseMotion
from ods.tracker.common_error.causes import SIGNIFICANT
from ods.tracker.measurement.pose.pose_noise import AT_LEAST_M
from ods.tracker.output.validity import SETTLE_S

JUMP_M = 2.0
"""Places may differ by so much, five standard deviations of each, and the whole way by either velocity: a place that
the INS computes once a second goes in steps."""
JUMP_RAD = math.radians(10.0)
"""Attitudes may differ by so much, five standard deviations of each,"""
FASTEST_TURN = math.radians(180.0)
"""and so much a second."""
FLICKER_RAD, FLICKER_SIGMAS, FLICKERS = math.radians(2.0), 3.0, 5
"""Attitudes that differ by so much more than noise and FASTEST_TURN explain, this many times within SETTLE_S, are of
two INSs, or of a disturbed compass. A heading that is computed once a second makes such steps, but fewer."""
STILL_S, STILL_M = 2.0, 1.0
"""A position constant for this time, s, while the velocity adds up to this distance, m, is not the vehicle's."""
COMPARED_S = 10.0
"""Time over which positions and velocities are compared, s: some metres suffice to distinguish them."""
VAGUE_RAD = math.radians(20.0)
"""Standard deviation of attitude, rad, from which on the direction of an echo is unknown, as while an INS aligns."""


class PoseSense:
    """Takes poses as they come; those older than the newest one, and those of no attitude, show nothing."""

    def __init__(self) -> None:
        self._newest: Pose | None = None
        self._settled: Pose | None = None
        """The first one of the newest place;"""
        self._way_m = 0.0
        """and the way by the velocity since."""
        self._jump = ""
        self._jumped_ns = 0
        self._flickers_ns: deque[int] = deque(maxlen=FLICKERS)
        self._motion = PoseMotion()
        self.disagreement = ""
        """How positions and velocities differ, "" where they do not: then obstacles are at their reported positions,
        but the reported closest approach is wrong."""

    def receive(self, pose: Pose) -> str:
        """Take in a pose; say by what it jumps, "" when it does not."""
        if abs(math.hypot(*pose.attitude) - 1.0) > NORM_TOLERANCE:
            return ""
        before, settled = self._newest, self._settled
        if before is None or settled is None:
            self._newest = self._settled = pose
            return ""
        if pose.t_ns <= before.t_ns:
            return ""
        turn = turn_between(before.attitude, pose.attitude)
        jump = _jump_of_place(settled, pose) or _jump_of_attitude(before, pose, turn)
        if jump:
            self._jump, self._jumped_ns = jump, pose.t_ns
        if turn > FLICKER_RAD + _explained_turn(before, pose, FLICKER_SIGMAS):
            self._flickers_ns.append(pose.t_ns)
        if pose.position_ned == settled.position_ned:
            self._way_m += math.hypot(*pose.velocity_body) * (pose.t_ns - before.t_ns) / NS
        else:
            self._settled, self._way_m = pose, 0.0
        self._compare(before, pose, bool(jump))
        self._newest = pose
        return jump

    def _compare(self, before: Pose, pose: Pose, jumps: bool) -> None:
        if jumps:
            self._motion = PoseMotion()
            return
        self._motion.add(before, pose)
        if self._motion.seconds >= COMPARED_S:
            self.disagreement = self._motion.disagreement()
            self._motion = PoseMotion()

    @property
    def is_doubtful(self) -> bool:
        """Places disagree with velocities, or do not change to the last digit, as those of an INS that hangs.

        If what is static then seems to move, it is the place that is wrong.
        """
        return bool(self.disagreement) or self._still_s > STILL_S

    @property
    def _still_s(self) -> float:
        if self._newest is None or self._settled is None:
            return 0.0
        return (self._newest.t_ns - self._settled.t_ns) / NS

    def reasons(self, now_ns: int) -> list[str]:
        """Return what is inconsistent now."""
        found = []
        # what was tracked before a jump is dropped (mission.py), and confirmed again after this time
        if self._jump and now_ns - self._jumped_ns < SETTLE_S * NS:
            found.append(f"{self._jump}: earlier objects are at wrong positions and are dropped")
        if self._way_m > STILL_M and self._still_s > STILL_S:
            way = f"its velocity makes {self._way_m:.1f} m"
            found.append(f"the position of the INS has been constant for {self._still_s:.1f} s, although {way}")
        if len(self._flickers_ns) == FLICKERS and now_ns - self._flickers_ns[0] < SETTLE_S * NS:
            found.append("the attitude jumps back and forth: are there two INSs, or is the compass disturbed?")
        if self._newest is not None and rotated(self._newest.attitude, (0.0, 0.0, 1.0))[2] < 0.0:
            found.append("the pose of the vehicle is upside down: is the INS mounted so, or an angle in another unit?")
        vague = 0.0 if self._newest is None else max(self._newest.sigma_attitude)
        if vague > VAGUE_RAD:
            sigma = f"{math.degrees(vague):.0f} deg"
            found.append(f"the INS reports an attitude with a standard deviation of {sigma}: is it still aligning?")
        return found


def _jump_of_place(earlier: Pose, later: Pose) -> str:
    seconds = (later.t_ns - earlier.t_ns) / NS
    carried = rotated(later.attitude, later.velocity_body)
    off = [b - a - v * seconds for a, b, v in zip(earlier.position_ned, later.position_ned, carried, strict=True)]
    way_m = (math.hypot(*earlier.velocity_body) + math.hypot(*later.velocity_body)) * seconds
    # what is more of a standard deviation is bias: when it is corrected, the vehicle moves away from all objects
    sigma_m = sum(min(AT_LEAST_M, max(each.sigma_position_ned)) for each in (earlier, later))
    off_m = math.hypot(*off)
    return f"the pose jumped by {off_m:.1f} m" if off_m > JUMP_M + SIGNIFICANT * sigma_m + way_m else ""


def _jump_of_attitude(earlier: Pose, later: Pose, turn: float) -> str:
    seconds = (later.t_ns - earlier.t_ns) / NS
    if turn <= JUMP_RAD + _explained_turn(earlier, later, SIGNIFICANT):
        return ""
    return f"the pose turned by {math.degrees(turn):.0f} deg within {seconds:.2f} s"


def _explained_turn(earlier: Pose, later: Pose, sigmas: float) -> float:
    """Return by how much attitudes may differ by noise of so many sigmas and by a turn of the vehicle, rad."""
    sigma = max(earlier.sigma_attitude) + max(later.sigma_attitude)
    return sigmas * sigma + FASTEST_TURN * (later.t_ns - earlier.t_ns) / NS
