"""Are near edges and outlines as exact as the list claims? Simulated scenes against what is true.

For each body that an obstacle stands for: the error of the list's `near_m`, its root mean square, the mean of
`sigma_near_m`, and the mean squared error over the claimed variance (NEES: 1 when errors are as large as claimed); of
walls half length, direction and place of the outline. `python -m benchmarks.circles.near_edges [SCENE.toml ...]
[--sonar S]`; without scenes those of `config/scenes/sea` whose bodies stand alone, and `config/scenes/walls.toml`.
"""

import argparse
import math
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.messages import Obstacle, ObstacleList
from ods.offline.mission import Mission, MissionSettings
from ods.offline.source import simulated
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.settings import Cylinder, Plane, Sphere
from ods.sim_sonar.scene.timeline import load_scene

SCENES = Path(__file__).resolve().parents[2] / "config" / "scenes"
FAMILY = ("gentle", "gravel", "ripples", "rocky", "slope")
"""Of `config/scenes/sea`: those whose bodies stand alone."""

SETTLED = 10
"""Pings after which lists are judged."""
NEAR_ENOUGH_M = 1.0
"""An obstacle stands for the body that its centre is inside of, or so near to."""


class Edge(NamedTuple):
    """One body in one list."""

    error_m: float
    sigma_m: float


class Strip(NamedTuple):
    """One wall in one list."""

    half_length_m: float
    true_m: float
    sigma_m: float
    turned_deg: float
    off_m: float


def main() -> None:
    """Run the scenes and print a row a body."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=Path)
    parser.add_argument("--sonar", default="seabat6012")
    args = parser.parse_args()
    print(f"{'':22} lists  near edge: mean error   rms   sigma  NEES | outline: half length (true)  NEES  turned   off")
    for path in args.scenes or [SCENES / "walls.toml", *(SCENES / "sea" / f"{name}.toml" for name in FAMILY)]:
        judge(path, args.sonar)


def judge(path: Path, sonar: str) -> None:
    """Run one scene and print a row a body."""
    scene = load_scene(path)
    source = simulated(scene, find_sonar(sonar, path))
    edges: dict[str, list[Edge]] = defaultdict(list)
    strips: dict[str, list[Strip]] = defaultdict(list)
    for step in list(Mission(MissionSettings()).steps(source.pings, source.poses))[SETTLED:]:
        t_s = (step.list.t_ns - source.pings[0].t_ns) / NS
        for body in scene.file.objects:
            take(body, step.list, t_s, edges[body.name], strips[body.name])
    for name, seen in edges.items():
        if seen:
            print(row(f"{path.stem} {name}", seen, strips[name]))


def take(
    body: Sphere | Cylinder | Plane, reported: ObstacleList, t_s: float, edges: list[Edge], strips: list[Strip]
) -> None:
    """Compare a body with the obstacle that stands for it, if one does."""
    if isinstance(body, Cylinder) or (isinstance(body, Plane) and body.width_m is None):
        return
    if body.position_ned is None or reported.head is None:
        return
    place = np.array(body.position_ned) + t_s * np.array(body.velocity_ned)
    head = np.array(reported.head.position_ned)
    stands = min(reported.obstacles, key=lambda each: math.dist(each.position_ned[:2], place[:2]), default=None)
    if stands is None or math.dist(stands.position_ned[:2], place[:2]) > stands.radius_m + NEAR_ENOUGH_M:
        return
    if stands.near_m is not None and stands.sigma_near_m is not None:
        edges.append(Edge(stands.near_m - nearest(body, place, head), stands.sigma_near_m))
    if isinstance(body, Plane) and stands.outline is not None:
        strips.append(strip_of(body, place, stands))


def nearest(body: Sphere | Plane, place: Floats, head: Floats) -> float:
    """Return the distance to the nearest point of a sphere, or of an upright plane at the height of the head."""
    if isinstance(body, Sphere):
        return float(np.linalg.norm(head - place)) - body.radius_m
    along = tangent(body)
    half_m = 0.5 * (body.width_m or 0.0)
    beside = np.clip((head - place) @ along, -half_m, half_m)
    return float(np.linalg.norm((head - place - beside * along)[:2]))


def tangent(wall: Plane) -> Floats:
    """Return (3,) the level direction of a wall."""
    north, east, _ = wall.normal_ned
    return np.array([-east, north, 0.0]) / math.hypot(north, east)


def strip_of(wall: Plane, place: Floats, stands: Obstacle) -> Strip:
    """Compare a wall with the outline of the obstacle that stands for it."""
    assert stands.outline is not None
    north, east, _ = tangent(wall)
    turned = math.degrees(stands.outline.azimuth_rad - math.atan2(east, north))
    off_m = math.dist(stands.outline.middle_ne, place[:2])
    reported = stands.outline.half_length_m, 0.5 * (wall.width_m or 0.0), stands.outline.sigma_half_length_m
    return Strip(*reported, abs((turned + 90.0) % 180.0 - 90.0), off_m)


def row(name: str, edges: list[Edge], strips: list[Strip]) -> str:
    """Return the line of one body."""
    error, sigma = np.array(edges).T
    text = f"{name:22} {len(error):5d} {error.mean():22.3f} {np.sqrt((error**2).mean()):6.3f} {sigma.mean():6.3f}"
    text += f" {((error / sigma) ** 2).mean():5.2f} |"
    if strips:
        length, true, claim, turned, off = np.array(strips).T
        nees = (((length - true) / claim) ** 2).mean()
        text += f" {length.mean():21.2f} ({true[0]:.1f}) {nees:7.2f} {turned.mean():5.1f}° {off.mean():5.2f} m"
    return text


if __name__ == "__main__":
    main()
