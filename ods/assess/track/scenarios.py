"""The fixed set of scenarios: the same number gives the same scenario, whatever else is run.

7 scans a second, 80 s, the sonar of the defaults of `Meta` (ods/tracker/scenario.py). Unless a scenario says otherwise,
objects lie within a metre of the vehicle's depth, and there is one false alarm a scan.
"""

import math
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ods.assess.track.case import RADIUS, VX, VY, VZ, Case, World, X, Y, observe
from ods.base.arrays import Floats
from ods.base.choices import none_of
from ods.base.errors import OdsError
from ods.tracker.scenario import Meta

RATE_HZ = 7.0
SECONDS = 80.0
DEPTH_M = 4.0
FIELD_SPEED = 1.5
"""Of the vehicle over a field, m/s."""
PAPER_STARTS = ((75.0, 4.3, 4.0), (60.0, -30.0, 4.0))
"""Where the objects of the worked example start: object 1 then leaves the view at 41 s [SSIE]."""
PAPER_VELOCITIES = ((-0.7, 0.4, 0.1), (0.5, 0.7, 0.1))
PAPER_RADII = (3.0, 6.0)
SONAR = Meta(clutter_lambda=1.0)

Random = np.random.Generator


@dataclass(frozen=True)
class Limits:
    """Targets for a scenario; None: no target."""

    gospa: float | None = None
    """In-view score over the reference's."""
    memory: float | None = None
    """Memory score over the reference's."""
    switches: int | None = 0
    consistent: bool = False
    """NEES not above its band: covariances include the fan's height, also where objects are at the vehicle's depth."""


@dataclass(frozen=True)
class Kind:
    """One entry of the set."""

    make: Callable[[Random], World]
    limits: Limits
    peers: tuple[str, ...] = ()
    """Those of `peers.PEERS` that get through it in a minute."""


AT_REST = Limits(gospa=1.03, memory=1.2, consistent=True)
MOVING = Limits(gospa=1.2)


def clock(seconds: float = SECONDS) -> Floats:
    """Return the (K,) times of the scans."""
    return np.arange(int(seconds * RATE_HZ)) / RATE_HZ


def world(t: Floats, starts: Floats, velocities: Floats, radius: Floats, speed: float, meta: Meta = SONAR) -> World:
    """Return a vehicle that goes north at `speed` from (0, 0, 4), and objects on straight lines: (N, 3) each."""
    count = len(starts)
    truth = np.empty((len(t), count, 7))
    truth[:, :, X : X + 3] = starts + velocities * t[:, None, None]
    truth[:, :, VX : VZ + 1] = velocities
    truth[:, :, RADIUS] = radius
    position = np.column_stack([speed * t, np.zeros_like(t), np.full_like(t, DEPTH_M)])
    shape = (len(t), count)
    pose = np.zeros((len(t), 5))
    return World(t, position, np.zeros_like(t), truth, meta, np.ones(shape, bool), np.ones(shape), pose)


def scattered(rng: Random, count: int, draw: Callable[[], tuple[float, float]], apart_m: float) -> Floats:
    """Return (count, 3) places, none nearer than `apart_m` to another."""
    places = np.zeros((0, 3))
    for _ in range(1000 * count):
        if len(places) == count:
            break
        north, east = draw()
        if not len(places) or np.hypot(places[:, 0] - north, places[:, 1] - east).min() > apart_m:
            places = np.vstack([places, (north, east, DEPTH_M + rng.uniform(-1.0, 1.0))])
    return places


def paper(rng: Random) -> World:
    """[SSIE] figures 6 and 7 without noise burst and false alarms."""
    speed, radii = 50.0 / 80.0, np.array(PAPER_RADII)
    quiet = Meta(clutter_lambda=0.0)
    return world(clock(), np.array(PAPER_STARTS), np.array(PAPER_VELOCITIES), radii, speed, quiet)


def paper_burst(rng: Random) -> World:
    """The worked example; from 4 to 6 s the noise of object 1 is eight times that of the sonar."""
    clean = paper(rng)
    clean.noise[(clean.t >= 4.0) & (clean.t < 6.0), 0] = 8.0
    return clean


def field(rng: Random, count: int) -> World:
    """Static objects over 220 m x 132 m that the vehicle goes into: 0.27 of them in view on average."""
    places = scattered(rng, count, lambda: (rng.uniform(5.0, 225.0), rng.uniform(-66.0, 66.0)), 4.0)
    return world(clock(), places, np.zeros_like(places), rng.uniform(0.5, 2.0, count), FIELD_SPEED)


def static_10(rng: Random) -> World:
    """Ten static objects, most of them in view all the time."""
    places = in_sector(rng, 10, 15.0, 95.0, 8.0)
    return world(clock(), places, np.zeros_like(places), rng.uniform(0.5, 2.0, 10), 0.1)


def in_view_300(rng: Random) -> World:
    """300 static objects in view of a vehicle that hovers."""
    places = in_sector(rng, 300, 10.0, 98.0, 2.5)
    return world(clock(), places, np.zeros_like(places), rng.uniform(0.3, 1.0, 300), 0.0)


def in_sector(rng: Random, count: int, near: float, far: float, apart_m: float) -> Floats:
    """Return (count, 3) places spread evenly over the sector of the first scan, 2 deg from its edges."""
    half = SONAR.half_fov - math.radians(2.0)

    def draw() -> tuple[float, float]:
        distance, bearing = math.sqrt(rng.uniform(near**2, far**2)), rng.uniform(-half, half)
        return distance * math.cos(bearing), distance * math.sin(bearing)

    return scattered(rng, count, draw, apart_m)


def movers(rng: Random) -> World:
    """Six objects at constant velocity."""
    return mixed(rng, 0, 6)


def mixed(rng: Random, resting: int = 6, moving: int = 4) -> World:
    """Static objects and some at constant velocity, 0.3 to 1.2 m/s, in front of a slow vehicle."""
    count = resting + moving
    places = in_sector(rng, count, 20.0, 85.0, 8.0)
    course, speed = rng.uniform(-np.pi, np.pi, count), rng.uniform(0.3, 1.2, count)
    speed[:resting] = 0.0
    velocities = np.column_stack([speed * np.cos(course), speed * np.sin(course), np.zeros(count)])
    return world(clock(), places, velocities, rng.uniform(0.5, 2.0, count), 0.3)


def crossing(rng: Random) -> World:
    """Two pairs of objects whose paths cross at the same time."""
    at, t0 = np.array([[45.0, -8.0], [65.0, 12.0]]), (rng.uniform(35.0, 42.0), rng.uniform(42.0, 50.0))
    starts, velocities = [], []
    for (north, east), when in zip(at, t0, strict=True):
        for side in (-1.0, 1.0):
            velocity = np.array([rng.uniform(-0.1, 0.2), side * rng.uniform(0.3, 0.5), 0.0])
            starts.append(np.array([north, east, DEPTH_M]) - velocity * when)
            velocities.append(velocity)
    return world(clock(), np.array(starts), np.array(velocities), np.array([1.0, 1.3, 0.8, 1.6]), 0.2)


def crossing_unresolved(rng: Random) -> World:
    """The same where two objects within 1 m and 2 deg give one echo between them."""
    return replace(crossing(rng), unresolved=True)


def clutter_50(rng: Random) -> World:
    """Ten objects and 50 false alarms a scan."""
    return replace(mixed(rng), meta=Meta(clutter_lambda=50.0))


def drop_out(rng: Random, seconds: float) -> World:
    """Ten objects; no echo at all for some seconds."""
    some = mixed(rng)
    some.sounding[(some.t >= 35.0) & (some.t < 35.0 + seconds)] = False
    return some


def half_silent(rng: Random) -> World:
    """Ten objects, half of them silent for 10 s."""
    some = mixed(rng)
    some.sounding[(some.t >= 35.0) & (some.t < 45.0), ::2] = False
    return some


def occlusion(rng: Random) -> World:
    """Ten small objects, a large one that moves across in front of them and hides one after the other."""
    distance, bearing = rng.uniform(45.0, 90.0, 10), np.deg2rad(np.linspace(-38.0, 38.0, 10))
    depth = DEPTH_M + rng.uniform(-1.0, 1.0, 10)
    places = np.column_stack([distance * np.cos(bearing), distance * np.sin(bearing), depth])
    starts = np.vstack([places, (28.0, -24.0, DEPTH_M)])
    velocities = np.zeros_like(starts)
    velocities[-1, 1] = 0.6
    radius = np.append(rng.uniform(0.5, 1.5, 10), 4.0)
    return replace(world(clock(), starts, velocities, radius, 0.0), occlusion=True)


def away_and_back(rng: Random) -> World:
    """Ten static objects; the vehicle turns away after 20 s and comes back 130 s later."""
    places = in_sector(rng, 10, 20.0, 90.0, 8.0)
    scene = world(clock(180.0), places, np.zeros_like(places), rng.uniform(0.5, 2.0, 10), 0.0)
    scene.yaw[:] = np.interp(scene.t, (20.0, 30.0, 140.0, 150.0), (0.0, np.pi, np.pi, 0.0))
    return scene


def pose_noise(rng: Random) -> World:
    """Ten objects; the reported pose is wrong by 0.1 m, 0.5 deg in yaw and 0.2 deg in roll and pitch (1 sigma),
    independently in each scan."""
    some = replace(mixed(rng), meta=Meta(clutter_lambda=1.0, pose_sigma_xy=0.1, pose_sigma_yaw=math.radians(0.5)))
    some.pose_error[:] = rng.standard_normal(some.pose_error.shape) * (0.1, 0.1, *np.radians((0.5, 0.2, 0.2)))
    return some


def pose_bias(rng: Random) -> World:
    """Ten objects; the reported pose is off by a bias that takes a minute and a half to swing once."""
    some = replace(mixed(rng), meta=Meta(clutter_lambda=1.0, pose_sigma_xy=0.2, pose_sigma_yaw=math.radians(0.3)))
    swing = np.sin(2.0 * np.pi * (some.t[:, None] / 90.0 + rng.random(3)))
    some.pose_error[:, :3] = math.sqrt(2.0) * swing * (0.2, 0.2, math.radians(0.3))
    return some


def manoeuvres(rng: Random) -> World:
    """Four objects that turn and change speed, two that rest."""
    some = mixed(rng, 2, 4)
    dt = np.diff(some.t, prepend=some.t[0])
    for i in range(2, 6):
        course, speed = rng.uniform(-np.pi, np.pi), rng.uniform(0.4, 1.0)
        begins = rng.uniform(15.0, 30.0)
        turning = (some.t > begins) & (some.t < begins + rng.uniform(8.0, 15.0))
        rate = rng.choice((-1.0, 1.0)) * rng.uniform(0.1, 0.25)
        heading = course + np.cumsum(rate * turning * dt)
        pace = np.where(some.t > begins + 25.0, 0.5 * speed, speed)
        some.truth[:, i, VX], some.truth[:, i, VY] = pace * np.cos(heading), pace * np.sin(heading)
        some.truth[:, i, X : Y + 1] = some.truth[0, i, X : Y + 1] + np.cumsum(
            some.truth[:, i, VX : VY + 1] * dt[:, None], axis=0
        )
    return some


GNN, BOTH = ("Stone Soup, GNN",), ("Stone Soup, GNN", "Stone Soup, JPDA")
KINDS: dict[str, Kind] = {
    "paper": Kind(paper, MOVING, BOTH),
    "paper, noise burst": Kind(paper_burst, MOVING, BOTH),
    "static 10": Kind(static_10, AT_REST, GNN),
    "static 100": Kind(lambda rng: field(rng, 100), AT_REST),
    "static 300": Kind(lambda rng: field(rng, 300), AT_REST),
    "static 300 in view": Kind(in_view_300, AT_REST),
    "constant velocity": Kind(movers, replace(MOVING, consistent=True), GNN),
    "crossing": Kind(crossing, MOVING, BOTH),
    "crossing, unresolved": Kind(crossing_unresolved, MOVING, GNN),
    "50 false alarms": Kind(clutter_50, MOVING),
    "drop-out 2 s": Kind(lambda rng: drop_out(rng, 2.0), MOVING, GNN),
    "drop-out 10 s": Kind(lambda rng: drop_out(rng, 10.0), MOVING, GNN),
    "half silent 10 s": Kind(half_silent, MOVING, GNN),
    "occlusion": Kind(occlusion, MOVING),
    "away 130 s and back": Kind(away_and_back, Limits(gospa=1.03, memory=1.2)),
    "pose noise": Kind(pose_noise, Limits(gospa=1.15)),
    "pose bias": Kind(pose_bias, MOVING),
    "manoeuvres": Kind(manoeuvres, MOVING),
}


def make(name: str, seed: int, kinds: Mapping[str, Kind] = KINDS) -> Case:
    """Return a scenario of a set. Raises OdsError for a name that there is not."""
    if name not in kinds:
        raise OdsError(f"scenario: {none_of(name, kinds)}")
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    return observe(name, kinds[name].make(rng), rng)
