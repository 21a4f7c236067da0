"""The pings of a scene in sequence at the sonar's own rate, each with its truth."""

from collections.abc import Iterator
from itertools import count
from typing import NamedTuple

from ods.base import clock
from ods.messages import Ping, Truth
from ods.sim_sonar.image import ImageSimulator

START_UTC_NS = 1_577_836_800_000_000_000
"""UTC of scene time 0 in recordings, 2020-01-01: the same command writes the same bytes."""


class Shot(NamedTuple):
    """One ping and its truth."""

    ping: Ping
    truth: Truth


def shots_of(images: ImageSimulator) -> Iterator[Shot]:
    """Yield pings without end, the first at scene time 0."""
    return (shot_at(images, number) for number in count())


def shot_at(images: ImageSimulator, number: int) -> Shot:
    """Return the ping of that number."""
    t_ns = round(number * images.sonar.ping_period_s * clock.NS)
    t_s = t_ns / clock.NS
    vehicle = images.scene.vehicle_at(t_s)
    north, east, down = vehicle.position_ned.tolist()
    w, x, y, z = vehicle.attitude.tolist()
    ping = images.ping(t_s, number, t_ns, START_UTC_NS + t_ns)
    return Shot(ping, Truth(number, t_ns, t_ns, (north, east, down), (w, x, y, z), images.truth(t_s, number)))
