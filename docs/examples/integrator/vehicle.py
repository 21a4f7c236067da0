"""Where the simulated vehicle is: it sails straight on, a little nose up and listing to port.

Sonar and INS of these examples share it, so that what the sonar sees fits where the INS says to be. Without ODS's code.
"""

import math
import time
from typing import NamedTuple

ROLL, PITCH, HEADING = -0.03, 0.05, 0.5
"""rad; body forward, starboard, down to north, east, down: port down, nose up, 29 deg east of north."""
SPEED = 0.3
"""m/s, level, towards the heading."""
START_NED = 100.0, 50.0, 10.0
"""m from the site's origin."""


class State(NamedTuple):
    """At one instant."""

    ned: tuple[float, float, float]
    velocity_ned: tuple[float, float, float]


def state(start_s: float) -> State:
    """Return where the vehicle is now; `start_s`: CLOCK_MONOTONIC when it left START_NED, s."""
    course = SPEED * math.cos(HEADING), SPEED * math.sin(HEADING), 0.0
    sailed_s = time.monotonic() - start_s
    north, east, down = (at + v * sailed_s for at, v in zip(START_NED, course, strict=True))
    return State((north, east, down), course)


def to_body(vector_ned: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return a vector as forward, starboard, down: turned by heading, then pitch, then roll."""
    north, east, down = vector_ned
    x, y = north * math.cos(HEADING) + east * math.sin(HEADING), east * math.cos(HEADING) - north * math.sin(HEADING)
    x, z = x * math.cos(PITCH) - down * math.sin(PITCH), x * math.sin(PITCH) + down * math.cos(PITCH)
    return x, y * math.cos(ROLL) + z * math.sin(ROLL), z * math.cos(ROLL) - y * math.sin(ROLL)
