"""`python -m benchmarks.circles.listed`: is what the list claims of a body's place, radius and near edge right?

The bodies, fan and speckle of benchmarks/circles/synthetic.py, pings of a hovering vehicle whose heading swings by 2
deg, through pipeline and tracker as on board. Of the last list: errors of the place along the line of sight, the radius
and the near edge, the standard deviations in the list, and the mean of error^2/sigma^2 over so many runs. What every
echo of a body has wrong alike, as its kind is not known, no number of pings takes away.
"""

import argparse
import math
from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import msgspec
import numpy as np

from benchmarks.circles.synthetic import Case, body, mean_intensity, ping_of
from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.messages import ObstacleList, Ping
from ods.offline.mission import Mission, MissionSettings
from ods.offline.poses import poses_along
from ods.sim_sonar.shots import START_UTC_NS

PERIOD_S, SWING, SWING_S = 0.15, math.radians(2.0), 9.0
DOWN_M = 20.0
WIDEST = 0.3
"""Bearings of bodies, rad."""
REACH_M = 3.0
"""An obstacle so near to a body's circle stands for it."""
ROWS = (
    *product(["front"], [1.5, 3.0], [20.0, 50.0, 90.0], [10.0]),
    *product(["half"], [1.5, 3.0], [50.0], [10.0, 25.0]),
    *product(["disc"], [0.15, 0.3], [15.0, 30.0, 60.0], [15.0, 25.0]),
    ("point", 0.0, 30.0, 25.0),
)


class Listed(NamedTuple):
    """Errors and standard deviations in one list, m."""

    along: float
    radius: float
    near: float
    sigma_along: float
    sigma_radius: float
    sigma_near: float


def listed_of(case: Case, rng: np.random.Generator, pings: int) -> Listed | None:
    """Return what the last list has of a body; None: nothing."""
    times = [round(k * PERIOD_S * NS) for k in range(pings)]
    yaw = SWING * np.sin(2.0 * math.pi * np.array(times) / NS / SWING_S)
    bearing, range_m = rng.uniform(-WIDEST, WIDEST), case.range_m + rng.uniform(-1.0, 1.0) * case.sonar.dr_m
    attitudes = [(math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle)) for angle in yaw.tolist()]
    poses = poses_along(times, np.tile((0.0, 0.0, DOWN_M), (pings, 1)), attitudes, START_UTC_NS)
    received = _pings(case, range_m, bearing - yaw, times, rng)
    *_, last = (step.list for step in Mission(MissionSettings()).steps(received, poses))
    return _taken(case, last, range_m, bearing)


def _pings(case: Case, range_m: float, bearings: Floats, times: list[int], rng: np.random.Generator) -> Iterator[Ping]:
    points = body(case.kind, case.size)
    for number, (bearing, t_ns) in enumerate(zip(bearings.tolist(), times, strict=True)):
        mean = 1.0 + 10.0 ** (0.1 * case.snr_db) * mean_intensity(points, range_m, bearing, case.sonar)
        ping = ping_of(30.0 * np.sqrt(mean * rng.exponential(size=mean.shape)), case.sonar)
        at = {"seq": number, "ping_number": number, "t_ns": t_ns, "t_rx_ns": t_ns, "utc_ns": START_UTC_NS + t_ns}
        yield msgspec.structs.replace(ping, **at)


def _taken(case: Case, reported: ObstacleList, range_m: float, bearing: float) -> Listed | None:
    """Return the obstacle that stands for the body, the head being at the origin."""
    sight = np.array([math.cos(bearing), math.sin(bearing)])
    stands = min(reported.obstacles, key=lambda o: math.dist(o.position_ned[:2], range_m * sight), default=None)
    if stands is None or math.dist(stands.position_ned[:2], range_m * sight) > case.size + REACH_M:
        return None
    north, east, _ = stands.sigma_position
    covariance = np.array([[north**2, stands.covariance_ne], [stands.covariance_ne, east**2]])
    near, sigma_near = (np.nan if value is None else value for value in (stands.near_m, stands.sigma_near_m))
    return Listed(
        float(sight @ stands.position_ned[:2]) - range_m, stands.radius_m - case.size,
        near - range_m - float(body(case.kind, case.size).ahead.min()),
        math.sqrt(sight @ covariance @ sight), stands.sigma_radius, sigma_near,
    )  # fmt: skip


def row(case: Case, runs: int, pings: int) -> str:
    """Return a line of the table."""
    seeds = ([seed, int(case.range_m), int(case.snr_db), int(100 * case.size)] for seed in range(runs))
    seen = np.array([v for seed in seeds if (v := listed_of(case, np.random.default_rng(seed), pings)) is not None])
    text = f"{case.kind:6}{case.size:6.2f}{case.range_m:5.0f}{case.snr_db:4.0f} {len(seen):3}/{runs}"
    if not len(seen):
        return text
    wrong, claimed = np.split(seen, 2, axis=1)
    columns = np.nanmean(wrong, axis=0), np.nanmean(claimed, axis=0), np.nanmean((wrong / claimed) ** 2, axis=0)
    return text + "".join(f" |{e:+6.2f}{s:6.2f}{nees:6.2f}" for e, s, nees in zip(*columns, strict=True))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=4, help="of each row")
    parser.add_argument("--pings", type=int, default=60, help="of a run")
    args = parser.parse_args()
    print("body radius range dB listed | along: error, sigma, NEES | radius          | near edge")
    for kind, size, range_m, snr_db in ROWS:
        print(row(Case(kind, size, range_m, snr_db), args.runs, args.pings), flush=True)


if __name__ == "__main__":
    main()
