"""Echoes as a stationary vehicle would have measured them: while they come back, the vehicle moves and turns.

The echo of a ping sent at t_tx from p_tx arrives at t_rx = t_tx + 2 r / c, r the measured range: half the way from p_tx
to the object and on to the sonar's place then, p_rx. The bearing is measured in the body frame at t_rx.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ods.base.clock import NS
from ods.compiled import native
from ods.pose.buffer import PoseEstimate
from ods.tracker.measurement.scan import Echoes

LONGEST_S = 10.0
"""No obstacle sonar listens longer: 7.5 km."""


@dataclass(frozen=True, slots=True)
class Listening:
    """The vehicle while a ping's echoes come back: a parabola through three poses.

    Swinging by up to 20 deg/s with a period of 4 s it is off by 0.001 deg at 100 m.
    """

    sent: PoseEstimate
    halfway: PoseEstimate
    end: PoseEstimate
    """When an echo from `range_m` arrives."""
    range_m: float


def poses_of(
    sent: PoseEstimate, range_max_m: float, sound_speed: float, pose_at: Callable[[int], PoseEstimate | None]
) -> Listening | None:
    """Return the poses while echoes from up to `range_max_m` come back; None when one is missing or invalid.

    `sent`: the pose at transmission; `sound_speed`: m/s; `pose_at`: the pose at a time in ns.
    """
    if not (range_max_m > 0.0 and sound_speed > 0.0 and 2.0 * range_max_m <= LONGEST_S * sound_speed):
        return None
    halfway_ns = round(range_max_m / sound_speed * NS)
    halfway, end = pose_at(sent.t_ns + halfway_ns), pose_at(sent.t_ns + 2 * halfway_ns)
    return None if halfway is None or end is None else Listening(sent, halfway, end, range_max_m)


def at_transmission(echoes: Echoes, listening: Listening) -> tuple[Echoes, float]:
    """Return the echoes with range, bearing and elevation from the pose at transmission, and the fan's turn, rad/m.

    The direction is taken as that of the plane the echo was seen in. The turn is that to starboard while an echo comes
    from a metre farther. What is farther than `listening` knows is taken as received at its end.
    """
    a, b, c = listening.sent, listening.halfway, listening.end
    places, attitudes = (a.position_ned, b.position_ned, c.position_ned), (a.attitude, b.attitude, c.attitude)
    mapped = echoes.table.copy()
    turn: float = native.see_at_transmission(echoes.table, places, attitudes, listening.range_m, mapped)
    return Echoes(mapped), turn / listening.range_m
