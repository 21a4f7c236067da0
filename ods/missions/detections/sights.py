"""Objects that a ping can show, and the visible part of each: those in the fan, and those that hide others."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.base.frames.geometry import wrap_angle
from ods.missions.world import World
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.steered import SteeredVehicle

RAYS = 2
"""A beam."""
WORDS = ("one", "range", "range squared", "radius", "width", "hidden", "edge", "end", "echo before")
"""What the laws go by, see `features_of`."""


class Sights(NamedTuple):
    """The m bodies of which a ping shows something."""

    body: Indices
    """(m,) numbers of the obstacles."""
    near_m: Floats
    """(m,) slant range of the nearest point that is seen."""
    radius_m: Floats
    """(m,) of the body."""
    bearing: Floats
    """(m,) of the middle of what is seen of it, rad."""
    width: Floats
    """(m,) of that, rad."""
    shown: Floats
    """(m,) its share of the body's width."""
    at_edge: Mask
    """(m,) it reaches the first or last ray of the fan."""
    at_end: Mask
    """(m,) its front does not end before the farthest range."""

    def take(self, rows: Indices | Mask) -> "Sights":
        """Return those of some rows."""
        return Sights._make(part[rows] for part in self)


class Fan(NamedTuple):
    """The region that a sonar observes."""

    rays: Floats
    """(k,) bearings, rad, evenly from border to border."""
    range_max_m: float
    beam_rad: float
    """Width of a beam."""
    half_vertical_rad: float
    sound_speed: float


def fan_of(sonar: SonarModel) -> Fan:
    """Return the region that a sonar observes."""
    bearing = sonar.plane_bearing_rad
    half = 0.5 * float(bearing[1] - bearing[0])
    rays = np.linspace(bearing[0] - half, bearing[-1] + half, RAYS * len(bearing) + 1)
    vertical = float(np.abs(sonar.elevation_rad).max()) + sonar.half_vertical_rad
    return Fan(rays, sonar.range_max_m, sonar.beam_width_rad, vertical, sonar.sound_speed)


def sights_of(world: World, vehicle: SteeredVehicle, t_s: float, fan: Fan) -> Sights:
    """Return what a ping sent at that time shows; the vehicle has gone on until its last echo is back.

    Ranges and bearings are as they are received: half of the way there and back, in the frame of the head at reception.
    """
    sent = vehicle.position(np.array(t_s))
    settings = world.settings
    away = np.hypot(*(world.places(t_s) - sent[:2]).T)
    within = np.flatnonzero(away - world.radius_m < fan.range_max_m)
    above = abs(float(sent[2]) - settings.down_m) - settings.height_m
    within = within[away[within] * math.tan(fan.half_vertical_rad) > above]
    there_s = away[within] / fan.sound_speed
    places = world.start_m[within] + (t_s + there_s)[:, None] * world.velocity[within]
    received = vehicle.position(t_s + 2.0 * there_s)[:, :2]
    attitude = vehicle.attitude(t_s + 2.0 * there_s)
    offset = places - received
    distance = 0.5 * (np.hypot(*(places - sent[:2]).T) + np.hypot(*offset.T))
    heading = 2.0 * np.arctan2(attitude[:, 3], attitude[:, 0])
    bearing = wrap_angle(np.arctan2(offset[:, 1], offset[:, 0]) - heading)
    return seen_of(distance, bearing, world.radius_m[within], fan, within)


def seen_of(distance: Floats, bearing: Floats, radius: Floats, fan: Fan, number: Indices | None = None) -> Sights:
    """Return what is seen of (n,) circles at a distance of their middles, m, and a bearing."""
    numbers = np.arange(len(distance)) if number is None else number
    off = np.abs(wrap_angle(bearing[:, None] - fan.rays))
    across = distance[:, None] * np.sin(off)
    met = (off < 0.5 * math.pi) & (across < radius[:, None])
    depth = np.sqrt(np.maximum(radius[:, None] ** 2 - across**2, 0.0))
    near = np.where(met, np.maximum(distance[:, None] * np.cos(off) - depth, 0.0), math.inf)
    nearest = near.min(axis=0, initial=math.inf)
    own = met & (near == nearest) & (nearest < fan.range_max_m)
    rows = np.flatnonzero(own.any(axis=1))
    own, last = own[rows], len(fan.rays) - 1
    first_ray, last_ray = own.argmax(axis=1), last - own[:, ::-1].argmax(axis=1)
    step = float(fan.rays[1] - fan.rays[0])
    half = np.arcsin(np.minimum(radius[rows] / np.maximum(distance[rows], 1e-9), 1.0))
    seen = own.sum(axis=1) * step
    here, each = met[rows], np.arange(len(rows))
    start, end = fan.rays[first_ray] - 0.5 * step, fan.rays[last_ray] + 0.5 * step
    begins = (first_ray > 0) & ~here[each, np.maximum(first_ray - 1, 0)]
    ends = (last_ray < last) & ~here[each, np.minimum(last_ray + 1, last)]
    start = np.where(begins, bearing[rows] - half, start)
    end = np.where(ends, bearing[rows] + half, end)
    near_m = np.where(own, near[rows], math.inf).min(axis=1, initial=math.inf)
    return Sights(
        body=numbers[rows],
        near_m=near_m,
        radius_m=radius[rows],
        bearing=0.5 * (start + end),
        width=seen,
        shown=np.minimum(seen / np.maximum(2.0 * half, step), 1.0),
        at_edge=(first_ray <= RAYS) | (last_ray >= last - RAYS),
        at_end=near_m + radius[rows] > fan.range_max_m,
    )


def features_of(sights: Sights, before: Mask, fan: Fan) -> Floats:
    """Return the (m, WORDS) numbers without units that laws go by; `before`: (m,) the ping before had its echo."""
    near = sights.near_m / fan.range_max_m
    return np.stack(
        [
            np.ones(len(near)),
            near,
            near * near,
            np.log(sights.radius_m),
            np.log(np.maximum(sights.width / fan.beam_rad, 0.5)),
            1.0 - sights.shown,
            sights.at_edge.astype(np.float64),
            sights.at_end.astype(np.float64),
            before.astype(np.float64),
        ],
        axis=1,
    )
