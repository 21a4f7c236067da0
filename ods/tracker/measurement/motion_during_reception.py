"""Echoes as a vehicle at rest would have measured them: while they come back, the vehicle moves and turns.

The echo of a ping sent at t_tx from p_tx arrives at t_rx = t_tx + 2 r / c, r the measured range: half the way from p_tx
to the object and on to the sonar's place then, p_rx. The bearing is measured in the body frame at t_rx.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.compiled.kernel import kernel
from ods.runtime.pose_buffer import PoseEstimate
from ods.tracker.measurement.scan import Echoes, echo_rows

_Three = tuple[Floats, Floats, Floats]

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
    """Return the poses while echoes from up to `range_max_m` come back; None when one is missing, or makes no sense.

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
    mapped, turn = _at_transmission(echoes.table, places, attitudes, listening.range_m)
    return Echoes(mapped), turn / listening.range_m


@kernel
def _at_transmission(table: Floats, places: _Three, attitudes: _Three, farthest: float) -> tuple[Floats, float]:
    """Return the table of the echoes and the turn from the first of three poses to the last, rad."""
    p0, p1, p2 = places
    q0, q1, q2 = attitudes
    mapped = table.copy()
    echoes, seen = echo_rows(table), echo_rows(mapped)
    for j in range(table.shape[1]):
        share = min(echoes.range_m[j] / farthest, 1.0)
        w0, w1, w2 = (1.0 - share) * (1.0 - 2.0 * share), 4.0 * share * (1.0 - share), share * (2.0 * share - 1.0)
        level, bearing = math.cos(echoes.elevation[j]), echoes.bearing[j]
        body = level * math.cos(bearing), level * math.sin(bearing), -math.sin(echoes.elevation[j])
        ux, uy, uz = _turned(_blend(q0, q1, q2, w0, w1, w2), body)
        dx = w1 * (p1[0] - p0[0]) + w2 * (p2[0] - p0[0])
        dy = w1 * (p1[1] - p0[1]) + w2 * (p2[1] - p0[1])
        dz = w1 * (p1[2] - p0[2]) + w2 * (p2[2] - p0[2])
        way, moved = 2.0 * echoes.range_m[j], dx * dx + dy * dy + dz * dz
        if not moved < way * way:  # a pose that outruns sound says nothing
            continue
        # the object is on the ellipse about p_tx and p_rx whose points are `way` from both together
        rest = (way * way - moved) / (2.0 * (way + ux * dx + uy * dy + uz * dz))
        place = dx + rest * ux, dy + rest * uy, dz + rest * uz
        x, y, z = _turned((q0[0], -q0[1], -q0[2], -q0[3]), place)
        seen.range_m[j] = math.sqrt(x * x + y * y + z * z)
        seen.bearing[j] = math.atan2(y, x)
        seen.elevation[j] = math.atan2(-z, math.hypot(x, y))
    ahead = _turned((q0[0], -q0[1], -q0[2], -q0[3]), _turned((q2[0], q2[1], q2[2], q2[3]), (1.0, 0.0, 0.0)))
    return mapped, math.atan2(ahead[1], ahead[0])


@kernel
def _blend(a: Floats, b: Floats, c: Floats, wa: float, wb: float, wc: float) -> tuple[float, float, float, float]:
    """Return the weighted mean of three quaternions as a unit one; a and c with the sign that is nearer to b."""
    wa = math.copysign(wa, wa * (a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]))
    wc = math.copysign(wc, wc * (c[0] * b[0] + c[1] * b[1] + c[2] * b[2] + c[3] * b[3]))
    w, x = wa * a[0] + wb * b[0] + wc * c[0], wa * a[1] + wb * b[1] + wc * c[1]
    y, z = wa * a[2] + wb * b[2] + wc * c[2], wa * a[3] + wb * b[3] + wc * c[3]
    unit = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    return w * unit, x * unit, y * unit, z * unit


@kernel
def _turned(q: tuple[float, float, float, float], v: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return the body vector v in the global frame; with the conjugate of q the other way round."""
    w, x, y, z = q
    cx = y * v[2] - z * v[1] + w * v[0]
    cy = z * v[0] - x * v[2] + w * v[1]
    cz = x * v[1] - y * v[0] + w * v[2]
    return v[0] + 2.0 * (y * cz - z * cy), v[1] + 2.0 * (z * cx - x * cz), v[2] + 2.0 * (x * cy - y * cx)
