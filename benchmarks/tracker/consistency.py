"""Is the covariance that is told as large as the errors? Monte Carlo over what a sonar cannot see, for every observer.

Objects are anywhere in the fan's elevation, bearings may be wide, the vehicle is pitched or rolled, its pose biased.
Each run has six objects, far apart, of one kind; the echoes are made here, from eq. 1 and the definition of range,
bearing and elevation, without the project's geometry. Printed is the mean of the squared error over the covariance,
north and east (NEES: 2 when errors are as large as told) some times after the first echo (`--at`), the root mean square
error, how many objects are taken to move, and how many of them are tracked at all.
`python -m benchmarks.tracker.consistency [--runs N]`.
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ods.base.clock import NS
from ods.messages import Sector
from ods.tracker.measurement.scan import Scan, Vehicle, echoes_of
from ods.tracker.observer.registry import OBSERVERS
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

Array = NDArray[np.float64]

RATE_HZ = 7.0
TOLD_S = (1.0, 3.0, 9.0, 19.8)
HALF_VERTICAL, HALF_FOV, FARTHEST_M = math.radians(10.0), math.radians(45.0), 130.0
BEARINGS = np.radians([-37.5, -22.5, -7.5, 7.5, 22.5, 37.5])
SIGMA_RADIUS_M = 0.3


@dataclass(frozen=True)
class Case:
    """A vehicle, its sonar, and objects that are first seen at `range_m`."""

    name: str
    range_m: float
    elevation: float = 1.0
    """Objects are anywhere in this share of the fan's height."""
    sigma_range_m: float = 0.1
    sigma_bearing_deg: float = 0.5
    object_speed: float = 0.0
    """m/s, in any direction, level."""
    object_climb: float = 0.0
    """Standard deviation of its climb, m/s."""
    vehicle_speed: float = 0.0
    """m/s, ahead, level."""
    pitch_deg: float = 0.0
    swing_deg: float = 0.0
    """Amplitude of a pitch that swings with a period of 6 s."""
    roll_deg: float = 0.0
    pose_m: float = 0.0
    """Standard deviation of a bias of north and of east, and the one told;"""
    yaw_deg: float = 0.0
    """of yaw;"""
    tilt_deg: float = 0.0
    """of roll and of pitch: the vehicle is tilted otherwise than it tells."""


CASES = (
    *(Case(f"hovering, pitch {p}, {r} m", r, pitch_deg=p) for r in (50.0, 90.0) for p in (0.0, 10.0, 20.0)),
    *(Case(f"1.5 m/s, pitch {p}, {r} m", r, pitch_deg=p, vehicle_speed=1.5) for r in (50.0, 90.0) for p in (0, 10, 20)),
    *(Case(f"pitch swings by 10 about {p}, 50 m", 50.0, pitch_deg=p, swing_deg=10.0) for p in (0.0, 10.0)),
    *(Case(f"object 0.5 m/s, pitch {p}", 60.0, pitch_deg=p, object_speed=0.5) for p in (0.0, 10.0, 20.0)),
    *(
        Case(f"bearing {s} deg at {r:.0f} m, object {v} m/s", r, 0.1, sigma_bearing_deg=s, object_speed=v)
        for r, s in ((80.0, 0.5), (80.0, 1.5), (80.0, 2.0), (80.0, 3.0), (100.0, 3.0))
        for v in (0.0, 0.5)
    ),
    *(Case(f"object {v} m/s", 50.0, 0.1, object_speed=v) for v in (0, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)),
    *(
        Case(f"object 0.5 m/s, climbs, pitch {p}", 60.0, 0.5, object_speed=0.5, object_climb=0.2, pitch_deg=p)
        for p in (0.0, 10.0, 20.0)
    ),
    Case("roll 10, 50 m", 50.0, roll_deg=10.0),
    Case("roll 10, 90 m", 90.0, roll_deg=10.0),
    Case("roll 10, 1.5 m/s", 50.0, roll_deg=10.0, vehicle_speed=1.5),
    Case("roll 10, pitch 10, object 0.5 m/s", 60.0, roll_deg=10.0, pitch_deg=10.0, object_speed=0.5),
    Case("roll 10, bearing 3.0 deg at 100 m", 100.0, sigma_bearing_deg=3.0, roll_deg=10.0),
    *(Case(f"tilt 1 deg, pitch {p}", 50.0, pitch_deg=p, tilt_deg=1.0) for p in (0.0, 20.0)),
    Case("tilt 1 deg, 1.5 m/s", 50.0, tilt_deg=1.0, vehicle_speed=1.5),
    Case("pose 0.3 m, 1 deg", 50.0, 0.1, pose_m=0.3, yaw_deg=1.0),
    Case("pose 0.3 m, 1 deg, 1.5 m/s", 60.0, 0.1, pose_m=0.3, yaw_deg=1.0, vehicle_speed=1.5),
    Case("pose 0.3 m, 1 deg, object 0.5 m/s", 50.0, 0.1, pose_m=0.3, yaw_deg=1.0, object_speed=0.5),
    Case("all of it, pitch 10, 1.5 m/s", 70.0, pitch_deg=10, pose_m=0.3, yaw_deg=1.0, vehicle_speed=1.5),
)


def rotation(roll: float, pitch: float, yaw: float) -> Array:
    """Return body to global: ahead, starboard, below to north, east, down."""
    c, s, cy, sy = math.cos(pitch), math.sin(pitch), math.cos(yaw), math.sin(yaw)
    unrolled: Array = np.array([[c * cy, -sy, s * cy], [c * sy, cy, s * sy], [-s, 0.0, c]])
    c, s = math.cos(roll), math.sin(roll)
    rolled: Array = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return unrolled @ rolled


@dataclass
class Found:
    """Per time and object; NaN where it is not tracked."""

    nees: Array
    error: Array
    moving: Array
    false: int


def one_run(case: Case, observer: str, rng: np.random.Generator, told_s: Sequence[float] = TOLD_S) -> Found:
    """Track the objects of one run, and look at them at the times `told_s`."""
    tracker, count = Tracker(TrackerSettings(observer=observer)), len(BEARINGS)
    sector = Sector(0.0, FARTHEST_M, -HALF_FOV, HALF_FOV, HALF_VERTICAL)
    elevation = case.elevation * rng.uniform(-HALF_VERTICAL, HALF_VERTICAL, count)
    level = np.cos(elevation)
    body = case.range_m * np.stack([level * np.cos(BEARINGS), level * np.sin(BEARINGS), -np.sin(elevation)])
    yaw = rng.uniform(-math.pi, math.pi)
    ahead = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    start = rng.uniform(-50.0, 50.0, 3)
    roll, pitch, swing = math.radians(case.roll_deg), math.radians(case.pitch_deg), math.radians(case.swing_deg)
    phase = rng.uniform(-math.pi, math.pi) if swing else 0.0
    rolled, pitched = math.radians(case.tilt_deg) * (rng.standard_normal(2) if case.tilt_deg else np.zeros(2))
    truth = start[:, None] + rotation(roll + rolled, pitch + pitched + swing * math.sin(phase), yaw) @ body
    course = rng.uniform(-math.pi, math.pi, count)
    velocity = case.object_speed * np.stack([np.cos(course), np.sin(course), np.zeros(count)])
    if case.object_climb:
        velocity[2] = case.object_climb * rng.standard_normal(count)
    bias, turned = case.pose_m * rng.standard_normal(2), math.radians(case.yaw_deg) * rng.standard_normal()
    sigma_position = np.array([case.pose_m, case.pose_m, 0.0])
    sigma_attitude = np.radians([case.tilt_deg, case.tilt_deg, case.yaw_deg])
    shape = len(told_s), count
    found = Found(np.full(shape, np.nan), np.full(shape, np.nan), np.full(shape, np.nan), 0)
    told = {round(t * RATE_HZ): row for row, t in enumerate(told_s)}
    for k in range(round(told_s[-1] * RATE_HZ) + 1):
        t = k / RATE_HZ
        place, now = start + case.vehicle_speed * t * ahead, truth + velocity * t
        tilt = pitch + swing * math.sin(phase + 2.0 * math.pi * t / 6.0)
        x, y, z = rotation(roll + rolled, tilt + pitched, yaw).T @ (now - place[:, None])
        distance, bearing, rise = np.sqrt(x**2 + y**2 + z**2), np.arctan2(y, x), np.arctan2(-z, np.hypot(x, y))
        seen = (np.abs(rise) <= HALF_VERTICAL) & (np.abs(bearing) < HALF_FOV)
        sigma_bearing = math.radians(case.sigma_bearing_deg)
        rows = np.zeros((count, 7))
        rows[:, 0] = distance + case.sigma_range_m * rng.standard_normal(count)
        rows[:, 1] = bearing + sigma_bearing * rng.standard_normal(count)
        rows[:, 3] = np.maximum(1.0 + SIGMA_RADIUS_M * rng.standard_normal(count), 0.05)
        rows[:, 4:] = case.sigma_range_m, sigma_bearing, SIGMA_RADIUS_M
        pose = place + np.array([*bias, 0.0])
        attitude = np.ascontiguousarray(rotation(roll, tilt, yaw + turned))
        vehicle = Vehicle(pose, attitude, sigma_position, sigma_attitude)
        t_ns = round(t * NS)
        tracker.step(Scan(t_ns, t_ns, vehicle, sector, echoes_of(rows[seen])[0]))
        if k in told:
            look(tracker, now, case, found, told[k])
    return found


def look(tracker: Tracker, truth: Array, case: Case, found: Found, row: int) -> None:
    """Note the errors of the tracks nearest to each object."""
    picture = tracker.snapshot()
    found.false += max(0, len(picture) - truth.shape[1])
    for i in range(truth.shape[1]):
        north, east = picture.position[:2] - truth[:2, i : i + 1]
        distance = np.hypot(north, east)
        if not len(distance) or distance.min() > 0.2 * case.range_m:
            continue
        j = int(distance.argmin())
        others = np.hypot(*(picture.position[:2, j, None] - truth[:2]))
        if others.min() < distance[j]:  # it is that of another object
            continue
        s_nn, s_ee, s_ne = *(picture.sigma_position[:2, j] ** 2), picture.covariance_ne[j]
        square = s_ee * north[j] ** 2 - 2.0 * s_ne * north[j] * east[j] + s_nn * east[j] ** 2
        found.nees[row, i] = square / (s_nn * s_ee - s_ne**2)
        found.error[row, i] = distance[j]
        found.moving[row, i] = picture.static[j] < 0.5


def summary(case: Case, observer: str, runs: int, seed: int, told_s: Sequence[float]) -> str:
    """Return one row of the table."""
    found = [one_run(case, observer, np.random.default_rng([seed, run]), told_s) for run in range(runs)]
    nees, error, moving = (
        np.concatenate([getattr(f, name) for f in found], axis=1) for name in ("nees", "error", "moving")
    )
    told = " ".join(f"{x:6.2f}" for x in np.nanmean(nees, axis=1))
    rms = " ".join(f"{x:5.2f}" for x in np.sqrt(np.nanmean(error**2, axis=1)))
    tracked, false = np.isfinite(nees[-1]).mean(), sum(f.false for f in found)
    return f"{case.name:40} {observer:12} {told} | {rms} | {np.nanmean(moving[-1]):5.2f} {tracked:5.2f} {false:3}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=40, help="runs of six objects each a row (default: 40)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="only cases with this in their name")
    parser.add_argument("--observers", nargs="+", default=list(OBSERVERS))
    parser.add_argument("--at", type=float, nargs="+", default=TOLD_S, metavar="S", help="seconds, ascending")
    arguments = parser.parse_args()
    times, wide = ", ".join(f"{t:.0f}" for t in arguments.at), len(arguments.at)
    print(
        f"{'':53} {f'NEES after {times} s':>{7 * wide - 1}} | {'rms error, m':>{6 * wide - 1}} | moving, tracked, false"
    )
    for case in CASES:
        if arguments.only in case.name:
            for observer in arguments.observers:
                print(summary(case, observer, arguments.runs, arguments.seed, arguments.at), flush=True)


if __name__ == "__main__":
    main()
