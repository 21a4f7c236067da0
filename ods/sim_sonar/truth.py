"""Ground truth of an image: position, visibility and echo strength of each object."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.base.frames import geometry
from ods.messages import TruthObject, Vector3
from ods.sim_sonar.pose import VehiclePose
from ods.sim_sonar.receiver.signal_chain import Levels
from ods.sim_sonar.scene.timeline import ObjectStates
from ods.sim_sonar.sonar.model import SonarModel

RING_BEAMS = 8
"""Beams to either side of an object that make its background."""
GUARD_BEAMS = 2
"""Beams next to it that do not: its echo leaks into them."""
RING_SAMPLES = 32
"""Samples of each of those beams that are enough for a median."""
RING_M = 1.0
"""Ranges before and behind it that do, m."""


class Echo(NamedTuple):
    """The level of one object, dB over 1 count^2, of the mean image: expected intensity, without speckle."""

    peak_db: float
    background_db: float


def truth_of(
    sonar: SonarModel,
    area: Floats,
    levels: Levels,
    pose: VehiclePose,
    objects: ObjectStates,
    received_ned: Floats,
) -> list[TruthObject]:
    """Return the bounded objects behind the image of a mean area (beams, samples).

    `pose`: at transmission; `received_ned`: (n, 3) the objects then, see motion_during_reception.as_received.
    """
    inside = within_fan(sonar, received_ned, objects.radius_m, pose)
    seen = geometry.global_to_body(received_ned, *pose)
    distance, bearing, _ = geometry.body_to_polar(seen)
    found = []
    for k, name in enumerate(objects.names):
        radius = float(objects.radius_m[k])
        echo = Echo(0.0, 0.0)
        if inside[k]:
            echo = echo_of(sonar, area, levels, float(distance[k]), float(bearing[k]), radius)
        place, velocity = _triple(objects.position_ned[k]), _triple(objects.velocity_ned[k])
        found.append(TruthObject(name, place, velocity, radius, bool(inside[k]), *echo))
    return found


def within_fan(sonar: SonarModel, position_ned: Floats, radius_m: Floats, pose: VehiclePose) -> Mask:
    """Return (n,) bool: which of (n, 3) objects are in the fan: centre in range and bearing, some of it in a main
    lobe."""
    distance, bearing, elevation = geometry.body_to_polar(geometry.global_to_body(position_ned, *pose))
    half_beam = 0.5 * sonar.beam_width_rad
    reach = np.arcsin(np.clip(radius_m / np.maximum(distance, 1e-9), 0.0, 1.0)) + sonar.half_vertical_rad
    return np.asarray(
        (distance >= sonar.range0_m)
        & (distance <= sonar.range_max_m)
        & (bearing >= sonar.bearing_rad.min() - half_beam)
        & (bearing <= sonar.bearing_rad.max() + half_beam)
        & (elevation <= sonar.elevation_rad.max() + reach)
        & (elevation >= sonar.elevation_rad.min() - reach)
    )


def echo_of(
    sonar: SonarModel, area: Floats, levels: Levels, range_m: float, bearing_rad: float, radius_m: float
) -> Echo:
    """Return the highest level within an object's circle, in the plane that receives it best, and the median around it.

    `area` is the mean area (beams, samples), m2. Levels are expected intensities: echo, noise and gain errors, without
    speckle and other sonars.
    """
    half = math.asin(min(1.0, radius_m / max(range_m, 1e-9)))
    bearings = sonar.plane_bearing_rad
    first = int(np.searchsorted(bearings, bearing_rad - half - 0.5 * sonar.beam_width_rad))
    last = max(first + 1, int(np.searchsorted(bearings, bearing_rad + half + 0.5 * sonar.beam_width_rad)))
    first, last = min(first, len(bearings) - 1), min(last, len(bearings))
    near, far = _samples(sonar, range_m, radius_m)
    outer_near, outer_far = _samples(sonar, range_m, radius_m + RING_M)
    around = slice(max(0, first - GUARD_BEAMS - RING_BEAMS), last + GUARD_BEAMS + RING_BEAMS)
    window = area.reshape(sonar.planes, len(bearings), -1)[:, around, outer_near:outer_far]
    here = slice(first - around.start, last - around.start)
    ranges = slice(near - outer_near, far - outer_near)
    plane = int(window[:, here, ranges].max(axis=(1, 2)).argmax())
    over_beams = levels.over_beams.reshape(sonar.planes, -1)[plane, around]
    power = window[plane] * levels.echo[outer_near:outer_far] + levels.noise[outer_near:outer_far]
    power = power * np.outer(over_beams, levels.over_range[outer_near:outer_far]).astype(np.float64) ** 2
    outside = np.ones(power.shape[0], np.bool_)
    outside[max(0, here.start - GUARD_BEAMS) : here.stop + GUARD_BEAMS] = False
    ring = power[outside] if outside.any() else np.delete(power, np.r_[ranges], axis=1)
    ring = ring[:, :: max(1, ring.shape[1] // RING_SAMPLES)]
    background = float(np.median(ring)) if ring.size else float(power.min())
    return Echo(_db(float(power[here, ranges].max())), _db(background))


def _samples(sonar: SonarModel, range_m: float, reach_m: float) -> tuple[int, int]:
    """Return first and last+1 sample within `reach_m` of a range, at least one."""
    first = math.floor((range_m - reach_m - sonar.range0_m) / sonar.dr_m + 0.5)
    last = math.floor((range_m + reach_m - sonar.range0_m) / sonar.dr_m + 0.5) + 1
    first = min(max(first, 0), sonar.samples - 1)
    return first, min(max(last, first + 1), sonar.samples)


def _db(power: float) -> float:
    return 10.0 * math.log10(max(power, 1e-12))


def _triple(vector: Floats) -> Vector3:
    return float(vector[0]), float(vector[1]), float(vector[2])
