"""Many steered vehicles at once: the motions of `ods.sim_sonar.steered`, on arrays."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.settings import VehicleSettings
from ods.sim_sonar.steered import YAW_S, VehicleState


class Motions(NamedTuple):
    """n vehicles, in the horizontal plane; each array (n,)."""

    north_m: Floats
    east_m: Floats
    heading_rad: Floats
    speed_m_s: Floats
    """Through the water."""
    turn_rad_s: Floats


class VehicleCommands(NamedTuple):
    """Set points of n vehicles; each array (n,)."""

    heading_rad: Floats
    speed_m_s: Floats


def motion_of(state: VehicleState) -> Motions:
    """Return one vehicle as Motions."""
    one = state.north_m, state.east_m, state.heading_rad, state.speed_m_s, state.turn_rad_s
    return Motions(*(np.array([each]) for each in one))


def moved(
    was: Motions,
    orders: VehicleCommands,
    can: VehicleSettings,
    current_m_s: tuple[float, float],
    dt_s: float,
    steps: int,
) -> tuple[Motions, Floats]:
    """Return the motions after `steps` steps, and (steps, n, 2) north, east at each; see `SteeredVehicle.step`."""
    north, east, heading, speed, turn = was
    wanted = np.clip(orders.speed_m_s, can.least_m_s, can.most_m_s)
    gain, most = can.acceleration_m_s2 * dt_s, math.radians(can.turn_rate_deg_s)
    twist = math.radians(can.turn_acceleration_deg_s2) * dt_s
    places = np.empty((steps, len(north), 2))
    for step in range(steps):
        speed = speed + np.clip(wanted - speed, -gain, gain)
        off = np.remainder(orders.heading_rad - heading + math.pi, 2.0 * math.pi) - math.pi
        turn = turn + np.clip(np.clip(off / YAW_S, -most, most) - turn, -twist, twist)
        middle = heading + 0.5 * turn * dt_s
        north = north + (speed * np.cos(middle) + current_m_s[0]) * dt_s
        east = east + (speed * np.sin(middle) + current_m_s[1]) * dt_s
        heading = heading + turn * dt_s
        places[step, :, 0], places[step, :, 1] = north, east
    return Motions(north, east, heading, speed, turn), places
