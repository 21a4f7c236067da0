"""Turns paths of vehicle and objects into a sonar's detections, with the truth."""

from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.base.errors import OdsError
from ods.tracker.scenario import Meta, Scenario

X, Y, Z, VX, VY, VZ, RADIUS = range(7)
"""Columns of a truth table."""
FALSE, MERGED = -1, -2
"""Sources of a detection that are no object: a false alarm, an echo of two objects."""


@dataclass(frozen=True)
class World:
    """K scans of N objects."""

    t: Floats
    """(K,) s."""
    position: Floats
    """(K, 3) of the vehicle, NED."""
    yaw: Floats
    """(K,) rad; roll and pitch are 0."""
    truth: Floats
    """(K, N, 7)."""
    meta: Meta
    sounding: Mask
    """(K, N) the object gives echoes."""
    noise: Floats
    """(K, N) factor on the standard deviations of its detections."""
    pose_error: Floats
    """(K, 5) north, east, yaw, roll, pitch: reported minus true."""
    unresolved: bool = False
    """Objects close to each other give one echo."""
    occlusion: bool = False
    """An object hides what is behind it."""


@dataclass(frozen=True)
class Case:
    """A scenario as the tracker receives it, with the truth."""

    name: str
    scenario: Scenario
    truth: Floats
    """(K, N, 7)."""
    position: Floats
    """(K, 3) and"""
    yaw: Floats
    """(K,) of the vehicle, true."""
    in_view: Mask
    """(K, N) inside sector and fan, hidden or silent ones too."""
    source: Indices
    """(M,) object that each detection comes from, FALSE or MERGED."""
    noise: Floats
    """(K, N) factor on the standard deviations of the objects' detections."""

    @property
    def moving(self) -> Mask:
        """(N,) objects that move at any time."""
        return np.asarray((np.abs(self.truth[:, :, VX : VZ + 1]) > 1e-9).any(axis=(0, 2)))


def polar(world_truth: Floats, position: Floats, yaw: Floats) -> tuple[Floats, Floats, Floats]:
    """Return slant range, bearing and elevation, (K, N) each, from (K, 3) positions and (K,) headings."""
    offset = world_truth[:, :, :3] - position[:, None]
    cos, sin = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    ahead = cos * offset[:, :, 0] + sin * offset[:, :, 1]
    side = cos * offset[:, :, 1] - sin * offset[:, :, 0]
    level = np.hypot(ahead, side)
    return np.hypot(level, offset[:, :, 2]), np.arctan2(side, ahead), np.arctan2(-offset[:, :, 2], level)


def observe(name: str, world: World, rng: np.random.Generator) -> Case:
    """Return a sonar's detections of the world."""
    meta = world.meta
    slant, bearing, elevation = polar(world.truth, world.position, world.yaw)
    in_view = (slant < meta.range_max) & (np.abs(bearing) < meta.half_fov) & (np.abs(elevation) < meta.half_vert)
    received = in_view & world.sounding & (rng.random(in_view.shape) < meta.pd)
    if world.occlusion:
        received &= ~hidden(slant, bearing, world.truth[:, :, RADIUS])
    rows, sources = [], []
    for k in range(len(world.t)):
        who = np.flatnonzero(received[k])
        true = np.column_stack([slant[k, who], bearing[k, who], world.truth[k, who, RADIUS]])
        if world.unresolved:
            true, who = merged(true, who)
        scale = np.array([meta.sigma_range, meta.sigma_bearing, meta.sigma_radius])
        factor = world.noise[k, np.maximum(who, 0)]
        echoes = true + factor[:, None] * scale * rng.standard_normal(true.shape)
        false = _false_alarms(meta, rng)
        table = np.concatenate([echoes, false])
        table[:, 2] = np.maximum(table[:, 2], 0.05)
        usable = (table[:, 0] > 0.0) & (np.abs(table[:, 1]) <= np.pi)
        amplitude = rng.uniform(60.0, 250.0, len(table))
        rows.append(np.column_stack([np.full(len(table), k), table, amplitude])[usable])
        sources.append(np.concatenate([who, np.full(len(false), FALSE)])[usable])
    reported = world.position.copy()
    reported[:, :2] += world.pose_error[:, :2]
    attitude = np.zeros_like(reported)
    attitude[:, :2] = world.pose_error[:, 3:]
    attitude[:, 2] = world.yaw + world.pose_error[:, 2]
    scenario = Scenario(world.t, reported, attitude, np.concatenate(rows), meta)
    source = np.concatenate(sources).astype(np.intp)
    return Case(name, scenario, world.truth, world.position, world.yaw, in_view, source, world.noise)


def _false_alarms(meta: Meta, rng: np.random.Generator) -> Floats:
    """Return (m, 3) range, bearing and radius, spread evenly over the sector's area."""
    count = rng.poisson(meta.clutter_lambda or 0.0)
    distance = meta.range_max * np.sqrt(rng.random(count))
    return np.column_stack([distance, rng.uniform(-meta.half_fov, meta.half_fov, count), rng.uniform(0.3, 3.0, count)])


def hidden(slant: Floats, bearing: Floats, radius: Floats) -> Mask:
    """Return (K, N): the object's centre is behind the circle of a nearer one."""
    half_width = np.arctan2(radius, slant)
    turned = np.abs(bearing[:, :, None] - bearing[:, None, :])
    behind = slant[:, :, None] > slant[:, None, :] + radius[:, None, :]
    return np.asarray((behind & (turned < half_width[:, None, :])).any(axis=2))


def merged(
    true: Floats, who: Indices, range_m: float = 1.0, bearing_rad: float = np.deg2rad(2.0)
) -> tuple[Floats, Indices]:
    """Merge the first two echoes nearer to each other than the sonar resolves into one between them, (m, 3)."""
    for i in range(len(who)):
        for j in range(i + 1, len(who)):
            if abs(true[i, 0] - true[j, 0]) < range_m and abs(true[i, 1] - true[j, 1]) < bearing_rad:
                both = 0.5 * (true[i] + true[j])
                both[2] = max(true[i, 2], true[j, 2]) + 0.25 * true[i, 0] * abs(true[i, 1] - true[j, 1])
                rest = np.setdiff1d(np.arange(len(who)), [i, j])
                return np.vstack([true[rest], both]), np.append(who[rest], MERGED)
    return true, who


def save_case(case: Case, path: Path) -> None:
    """Write the case as a file that `ods track` reads, with its truth. Raises OdsError."""
    scenario = case.scenario
    try:
        with path.open("wb") as file:
            np.savez_compressed(
                file,
                t=scenario.t,
                auv_pos=scenario.auv_pos,
                auv_rpy=scenario.auv_rpy,
                det=scenario.det,
                truth=case.truth,
                meta=np.array(msgspec.json.encode(scenario.meta).decode()),
            )
    except OSError as error:
        raise OdsError(f"{path}: {error.strerror}") from error
