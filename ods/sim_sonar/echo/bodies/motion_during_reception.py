"""Surroundings of a sonar that moves and turns while the echoes come back.

The sonar measures half the way from where it sent the ping to the object and on to where it receives the echo, at
t_tx + 2 r / c, and the direction in its frame then.
"""

import math
from collections.abc import Callable

import numpy as np

from ods.base.frames.geometry import rotation_matrix
from ods.compiled import native
from ods.sim_sonar.echo.bodies.bodies import Bodies, middles
from ods.sim_sonar.pose import Times, VehiclePose


def as_received(
    objects: Bodies, t_s: float, sent: VehiclePose, sound_speed: float, pose_at: Callable[[Times], VehiclePose]
) -> Bodies:
    """Return the bodies, NED, of which a stationary vehicle in the pose `sent` has the same echoes.

    `objects`: as they are, NED; `sent`: the pose at scene time `t_s`; `sound_speed`: m/s; `pose_at`: the poses at scene
    times (...). An object is received as a whole, at the reception of what comes from its middle (see bodies.middles).
    That the way back is longer or shorter than the way there is left out in the instant, not in the range: at 2 m/s and
    20 deg/s that is 0.004 deg at 100 m.
    """
    middle = middles(objects, sent.position_ned)
    there = np.sqrt(np.square(middle - sent.position_ned).sum(axis=1))
    received = np.empty_like(objects)
    native.as_received(objects, middle, sent, pose_at(t_s + there * (2.0 / sound_speed)), received)
    return received


def turn_per_metre(
    sent: VehiclePose, t_s: float, farthest_m: float, sound_speed: float, pose_at: Callable[[Times], VehiclePose]
) -> float:
    """Return what the heading turns to starboard while an echo comes from a metre farther, rad.

    Arguments as of `as_received`; `farthest_m`: range up to which it is taken to turn evenly.
    """
    received = pose_at(t_s + farthest_m * (2.0 / sound_speed))
    before, after = rotation_matrix(sent.attitude), rotation_matrix(received.attitude)
    turned = math.atan2(after[1, 0], after[0, 0]) - math.atan2(before[1, 0], before[0, 0])
    return math.remainder(turned, 2.0 * math.pi) / farthest_m
