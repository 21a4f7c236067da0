"""uFldCollObDetect of MOOS-IvP as a second judge of a mission: encounters, near misses and collisions by its own count.

As read in moos-ivp a2a9b716c. A vehicle is a point, an obstacle a convex polygon; at each iteration it takes the newest
place of each and their distance. It reports an encounter's least distance once the vehicle is out of `encounter_dist`
again, so a vehicle that ends within is led away. Time and speed are nothing to it: a step may follow as soon as the one
before was judged. What tells so is a beacon, a second vehicle far from all else that comes nearer to an obstacle of its
own by a hair at each step: that is a new least distance of all, which it reports at once (OB_GLOBAL_MIN).
"""

import math
import select
import socket
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from ods.missions.flight import Flight
from ods.missions.settings import Campaign
from ods.missions.world import World
from ods.sim_sonar.steered import VehicleState
from tests.bridge import moos_datagrams
from tests.bridge.played import drained, receiver
from tests.peers.moos import community, free_port, say

CORNERS = 72
CORNER = 1.0 / math.cos(math.pi / CORNERS)
"""How far the corners of a polygon are from the centre of the circle that it stands for, in radii."""
ENCOUNTER_M = 15.0
BEACON_X_M, AWAY_X_M = -20_000.0, 20_000.0
BEACON_M, HAIR_M = 0.02, 1e-6
"""Its first distance: less than that of any vehicle that has only just collided."""
AGAIN_S, PATIENCE_S = 0.5, 60.0
SETTINGS = """
  AppTick = 4
  IterateMode = 1
  MaxAppTick = 0
  encounter_dist = {encounter}
  near_miss_dist = {near_miss}
  collision_dist = {collision}
  encounter_flag = ENCOUNTER_$ID=$DIST
  near_miss_flag = NEAR_MISS_$ID=$DIST
  collision_flag = COLLISION_$ID=$DIST
"""
"""IterateMode 1: it iterates whenever something has come; its default is at AppTick only."""
SAID = ("OB_GLOBAL_MIN", "ENCOUNTER_*:*", "NEAR_MISS_*:*", "COLLISION_*:*")


class Judged(NamedTuple):
    """Least distance of the vehicle's centre from obstacles, m, by their numbers in the world."""

    encounters: dict[int, float]
    near_misses: dict[int, float]
    collisions: dict[int, float]


def judged(campaign: Campaign, flown: Flight) -> Judged:
    """Return what it says of a mission."""
    with _referee(campaign.vehicle.radius_m, campaign.near_miss_m) as referee:
        referee.place(flown.world)
        for state in flown.vehicle.way[1:]:
            referee.see(flown.world, state)
        return referee.verdict()


@contextmanager
def _referee(radius_m: float, near_miss_m: float) -> Iterator["_Referee"]:
    into = free_port(socket.SOCK_DGRAM)
    settings = SETTINGS.format(encounter=ENCOUNTER_M, near_miss=radius_m + near_miss_m, collision=radius_m)
    with receiver() as peer, community("uFldCollObDetect", settings, SAID, into, peer.getsockname()[1]):
        yield _Referee(peer, into)


class _Referee:
    """The program, from its start on."""

    def __init__(self, peer: socket.socket, into: int) -> None:
        self._peer, self._into = peer, into
        self._beacon_m = BEACON_M
        self._said: dict[str, dict[int, float]] = {}
        self._judge({"KNOWN_OBSTACLE": [_circle("beacon", BEACON_X_M - 1.0, 0.0, 1.0)]})

    def place(self, world: World) -> None:
        """Tell it of all obstacles."""
        self._judge({"KNOWN_OBSTACLE": _circles(world, 0.0, range(len(world.radius_m)))})

    def see(self, world: World, state: VehicleState) -> None:
        """Tell it where the vehicle and all that moves is now."""
        moving = np.flatnonzero(world.velocity.any(axis=1)).tolist()
        vehicle = _report("auv", state.east_m, state.north_m, state.t_s)
        self._judge({"KNOWN_OBSTACLE": _circles(world, state.t_s, moving), "NODE_REPORT": [vehicle]})

    def verdict(self) -> Judged:
        """Lead the vehicle away and return what was said of it."""
        self._judge({"NODE_REPORT": [_report("auv", AWAY_X_M, 0.0, 0.0)]})
        self._judge({})  # what an iteration said has come before what the next one says
        return Judged(*(self._said.get(kind, {}) for kind in ("ENCOUNTER", "NEAR_MISS", "COLLISION")))

    def _judge(self, reported: dict[str, list[str]]) -> None:
        """Tell it something and wait until an iteration has followed."""
        first_m, deadline_s = self._beacon_m, time.monotonic() + PATIENCE_S
        while not self._received(first_m):
            assert time.monotonic() < deadline_s, "uFldCollObDetect does not answer"
            for key, values in reported.items():
                for value in values:
                    say(self._peer, self._into, key, value)
            say(self._peer, self._into, "NODE_REPORT", _report("beacon", BEACON_X_M + self._beacon_m, 0.0, 0.0))
            self._beacon_m -= HAIR_M
            select.select([self._peer], [], [], AGAIN_S)

    def _received(self, first_m: float) -> bool:
        """Take what has come; return whether the beacon was seen at that distance or nearer."""
        seen = False
        for message in map(moos_datagrams.read, drained(self._peer)):
            if message.key == "OB_GLOBAL_MIN":
                seen = seen or message.value < first_m + 0.5 * HAIR_M
            else:
                kind, _, number = message.key.rpartition("_")
                which = self._said.setdefault(kind, {})
                which[int(number)] = min(message.value, which.get(int(number), math.inf))
        return seen


def _report(name: str, x_m: float, y_m: float, t_s: float) -> str:
    return f"NAME={name},TYPE=ship,TIME={t_s:.3f},X={x_m:.7f},Y={y_m:.7f}"


def _circles(world: World, t_s: float, which: Iterable[int]) -> list[str]:
    places, radii = world.places(t_s).tolist(), world.radius_m.tolist()
    return [_circle(f"{number}", places[number][1], places[number][0], radii[number]) for number in which]


def _circle(label: str, x_m: float, y_m: float, radius_m: float) -> str:
    """Return a polygon whose sides touch the circle from without; one does so due east."""
    return f"format=radial,x={x_m:.7f},y={y_m:.7f},radius={radius_m * CORNER:.7f},pts={CORNERS},label={label}"
