"""Scenarios for the tracker's tests: paths of vehicle and objects to detections, with the truth beside them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.base.clock import NS
from ods.base.frames.geometry import global_to_body, quat_from_euler
from ods.messages import Sector
from ods.tracker.measurement.model import PredictedMeasurement, predicted_measurements
from ods.tracker.measurement.scan import Echoes, Scan, Vehicle, echoes_of, vehicle_at
from ods.tracker.named import Named
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.tracker import Tracker

RATE_HZ = 7.0
RANGE_MAX_M = 100.0
HALF_FOV = math.radians(45.0)
HALF_VERTICAL = math.radians(10.0)
SIGMA_RANGE = 0.1
SIGMA_BEARING = math.radians(0.5)
SIGMA_RADIUS = 0.3
SECTOR = Sector(0.0, RANGE_MAX_M, -HALF_FOV, HALF_FOV, HALF_VERTICAL)
NO_SIGMA = np.zeros(3)

Rings = Sequence[tuple[float, float]]


def echoes(rows: list[tuple[float, float, float]]) -> Echoes:
    """Return echoes of (range, bearing, radius) rows."""
    table = np.array(
        [(r, b, 0.0, radius, SIGMA_RANGE, SIGMA_BEARING, SIGMA_RADIUS) for r, b, radius in rows], np.float64
    )
    return echoes_of(table.reshape(-1, 7))[0]


def scan(
    t_s: float,
    position: Floats,
    yaw: float,
    rows: list[tuple[float, float, float]],
    usable: bool = True,
    processed: Rings = (),
) -> Scan:
    """Return the scan of a vehicle at `position` (3,) that looks along `yaw`."""
    t_ns = round(t_s * NS)
    attitude = quat_from_euler(0.0, 0.0, yaw)
    return Scan(t_ns, t_ns, vehicle_at(position, attitude, NO_SIGMA, NO_SIGMA), SECTOR, echoes(rows), usable, processed)


@dataclass
class Course:
    """K instants of a vehicle and N objects."""

    t: Floats
    position: Floats
    """(K, 3) of the vehicle."""
    yaw: Floats
    """(K,)."""
    objects: Floats
    """(K, N, 3)."""
    radius: Floats
    """(N,)."""

    def polar(self, k: int) -> tuple[Floats, Floats, Mask]:
        """Return true ranges and bearings (N,) at instant k, and which objects are in the sonar's view."""
        body = global_to_body(self.objects[k], self.position[k], quat_from_euler(0.0, 0.0, self.yaw[k]))
        distance = np.linalg.norm(body, axis=1)
        bearing = np.arctan2(body[:, 1], body[:, 0])
        elevation = np.arcsin(np.clip(body[:, 2] / distance, -1.0, 1.0))
        seen = (distance < RANGE_MAX_M) & (np.abs(bearing) < HALF_FOV) & (np.abs(elevation) < HALF_VERTICAL)
        return distance, bearing, seen


def course(seconds: float, speed: float, starts: Floats, velocities: Floats, radius: Floats) -> Course:
    """Return a vehicle at (0, 0, 4) that goes north, and objects on straight lines."""
    t = np.arange(int(seconds * RATE_HZ)) / RATE_HZ
    position = np.column_stack([speed * t, np.zeros_like(t), np.full_like(t, 4.0)])
    return Course(t, position, np.zeros_like(t), starts + velocities * t[:, None, None], radius)


@dataclass
class Run:
    """A tracker that went through a course."""

    tracker: Tracker
    snapshots: list[Snapshot]
    ended: list[tuple[int, int]]
    """Scan index and id of every object terminated."""

    def ids(self) -> set[int]:
        """Return every id ever reported."""
        return {i for picture in self.snapshots for i in picture.id.tolist()}

    def states(self, object_id: int) -> list[int]:
        """Return the state of an object in each picture, 0 where it is not in it."""
        return [int(next(iter(p.state[p.id == object_id]), 0)) for p in self.snapshots]

    def nearest(self, k: int, place: Floats) -> tuple[int, float]:
        """Return id and horizontal distance of the object nearest to (3,) `place` in picture k."""
        picture = self.snapshots[k]
        distance = np.hypot(*(picture.position[:2] - place[:2, None]))
        best = int(np.argmin(distance))
        return int(picture.id[best]), float(distance[best])


def run(
    path: Course,
    tracker: Tracker,
    seed: int = 0,
    detection_probability: float = 0.9,
    clutter: float = 0.0,
    silent: tuple[float, float] | None = None,
    turns: Sequence[Rings] = ((),),
) -> Run:
    """Take the tracker through a course; `silent`: from when to when no object gives an echo.

    turns: the ranges that are processed, in turn; empty: all.
    """
    rng = np.random.default_rng(seed)
    snapshots, ended = [], []
    for k, t in enumerate(path.t.tolist()):
        distance, bearing, seen = path.polar(k)
        seen &= rng.random(len(seen)) < detection_probability
        if silent and silent[0] <= t < silent[1]:
            seen[:] = False
        rows = [
            (
                distance[i] + rng.normal(0.0, SIGMA_RANGE),
                bearing[i] + rng.normal(0.0, SIGMA_BEARING),
                max(0.05, path.radius[i] + rng.normal(0.0, SIGMA_RADIUS)),
            )
            for i in np.flatnonzero(seen)
        ]
        rows += [
            (RANGE_MAX_M * math.sqrt(rng.random()), rng.uniform(-HALF_FOV, HALF_FOV), rng.uniform(0.3, 3.0))
            for _ in range(rng.poisson(clutter))
        ]
        processed = turns[k % len(turns)]
        rows = [row for row in rows if not processed or any(begin <= row[0] < stop for begin, stop in processed)]
        outcome = tracker.step(scan(t, path.position[k], float(path.yaw[k]), rows, processed=processed))
        if outcome.ended is not None:
            ended += [(k, i) for i in outcome.ended.id.tolist()]
        snapshots.append(tracker.snapshot())
    return Run(tracker, snapshots, ended)


def predicted_measurement(
    position: Floats, variance: Floats, covariance_ne: Floats, vehicle: Vehicle, by_height: Floats | None = None
) -> Named[PredictedMeasurement]:
    """Return what the sonar should measure of objects: arrays as in `Estimate`; by_height: None for all 0."""
    by_height = np.zeros_like(position[..., :2, :]) if by_height is None else by_height
    return predicted_measurements(vehicle, (position, variance, covariance_ne, by_height))[0]
