"""What surrounds a sonar as it hears it that moves and turns while the echoes come back.

The sonar measures half the way from where it sent the ping to the object and on to where it hears the echo, at
t_tx + 2 r / c, and the direction in its frame then.
"""

import math
from collections.abc import Callable

import numpy as np

from ods.base.arrays import Floats
from ods.base.geometry import rotation_matrix
from ods.sim_sonar.echo.bodies import Bodies, middles
from ods.sim_sonar.kernel import compiled
from ods.sim_sonar.pose import Times, VehiclePose

LEAST_DISTANCE_M = 1e-9
"""Keeps the direction to a plane through the sonar finite."""


def as_heard(
    objects: Bodies, t_s: float, sent: VehiclePose, sound_speed: float, pose_at: Callable[[Times], VehiclePose]
) -> Bodies:
    """Return the bodies, NED, of which a vehicle at rest in the pose `sent` has the same echoes.

    `objects`: as they are, NED; `sent`: the pose at scene time `t_s`; `sound_speed`: m/s; `pose_at`: the poses at scene
    times (...). An object is heard as a whole, at the reception of what comes from its middle (see bodies.middles).
    That the way back is longer or shorter than the way there is left out in the instant, not in the range: at 2 m/s and
    20 deg/s that is 0.004 deg at 100 m.
    """
    middle = middles(objects, sent.position_ned)
    there = np.sqrt(np.square(middle - sent.position_ned).sum(axis=1))
    return _as_heard(objects, middle, sent, pose_at(t_s + there * (2.0 / sound_speed)))


def turn_per_metre(
    sent: VehiclePose, t_s: float, farthest_m: float, sound_speed: float, pose_at: Callable[[Times], VehiclePose]
) -> float:
    """Return what the heading turns to starboard while an echo comes from a metre farther, rad.

    Arguments as of `as_heard`; `farthest_m`: range up to which it is taken to turn evenly.
    """
    heard = pose_at(t_s + farthest_m * (2.0 / sound_speed))
    before, after = rotation_matrix(sent.attitude), rotation_matrix(heard.attitude)
    turned = math.atan2(after[1, 0], after[0, 0]) - math.atan2(before[1, 0], before[0, 0])
    return math.remainder(turned, 2.0 * math.pi) / farthest_m


@compiled
def _as_heard(objects: Bodies, middle: Floats, sent: VehiclePose, heard: VehiclePose) -> Bodies:
    """Move and turn each body about its middle; `sent`: one pose, `heard`: (n,) poses, at reception."""
    out = objects.copy()
    sent_ned, forth = sent.position_ned, _rotation(sent.attitude)
    turn = np.empty((3, 3))
    for k in range(len(objects)):
        heard_ned, back = heard.position_ned[k], _rotation(heard.attitude[k])
        for i in range(3):
            for j in range(3):
                turn[i, j] = forth[i, 0] * back[j, 0] + forth[i, 1] * back[j, 1] + forth[i, 2] * back[j, 2]
        there, again = _distance(middle[k], sent_ned), max(_distance(middle[k], heard_ned), LEAST_DISTANCE_M)
        stretch = 0.5 * (there + again) / again
        body, moved = objects[k], out[k]
        for i in range(3):
            place = sent_ned[i]
            for j in range(3):
                way, centre = middle[k, j] - heard_ned[j], body["centre"][j] - middle[k, j]
                place += turn[i, j] * (stretch * way + centre)
            moved["centre"][i] = place
        for axis in range(3):
            for i in range(3):
                along = 0.0
                for j in range(3):
                    along += turn[i, j] * body["axes"][axis, j]
                moved["axes"][axis, i] = along
    return out


@compiled
def _distance(a: Floats, b: Floats) -> float:
    return math.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2)


@compiled
def _rotation(q: Floats) -> Floats:
    """Return the matrix that turns body vectors into global ones: geometry.rotation_matrix of one quaternion."""
    w, x, y, z = q[0], q[1], q[2], q[3]
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
