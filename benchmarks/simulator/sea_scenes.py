"""Writes scenes like those of issue 14, drawn at random, so that sea-beds that nobody has chosen by can be judged.

`python -m benchmarks.simulator.sea_scenes FOLDER [--each 3] [--seed 0]`, then `ods assess sea --scene FOLDER`. Four
kinds of bed, a vehicle at 2.5 to 9 m over them and at 0.2 to 2 m/s, three spheres of 0.8 to 2 m, the third moving, 3.5
to 6 m over the bed below them.
"""

import argparse
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.simulator.scene_text import Drawn, Surface, new_seed, object_text, scene_text as text_of

DOWN_M = 20.0
"""Of the sonar."""
ALTITUDES_M, SPEEDS, HEIGHTS_M, RADII_M, AHEAD_M = (2.5, 9.0), (0.2, 2.0), (3.5, 6.0), (0.8, 2.0), (45.0, 85.0)
LOWEST_M = 2.0
"""Over a bed that rises ahead, in the end: lower, its crests stand in the vehicle's way."""
ASIDE = 0.5
"""Of the distance ahead, at most."""
MOVER, SECONDS, CLEAR_M = "mover", 35.0, 3.0
"""The moving one, how long a scene lasts, and how far the vehicle passes from all."""
SHALLOWEST_M, DEEPEST_M = DOWN_M - 4.0, DOWN_M + 4.0
"""Of spheres: the fan would look past them."""


class Bed(NamedTuple):
    """A kind of bed, which may rise ahead."""

    rms_height_m: float
    correlation_m: float
    rises_deg: float = 0.0


BEDS = {"gentle": Bed(0.05, 3.0), "slope": Bed(0.15, 3.0, 3.0), "rocky": Bed(0.25, 2.0), "ripples": Bed(0.12, 0.8)}

SPHERE = Surface(cd=0.1, cs=0.05, sigma_deg=15.0)


def scene_text(bed: Bed, rng: np.random.Generator) -> str:
    """Return a scene over such a bed."""
    depth, speed = DOWN_M + rng.uniform(*ALTITUDES_M), rng.uniform(*SPEEDS)
    depth = max(depth, DOWN_M + LOWEST_M + speed * SECONDS * math.tan(math.radians(bed.rises_deg)))
    objects = "".join(_sphere(name, bed, depth, speed, rng) for name in ("one", "two", MOVER))
    drawn = Drawn(
        new_seed(rng), speed, rng.uniform(0.0, 2.0), rng.uniform(0.0, 4.0), depth, bed.rises_deg, bed.rms_height_m,
        bed.correlation_m, cd=0.5, cs=0.2, range_correlation=0.2,
    )  # fmt: skip
    return text_of(drawn, objects, seconds=SECONDS, down_m=DOWN_M)


def _sphere(name: str, bed: Bed, depth_m: float, speed: float, rng: np.random.Generator) -> str:
    """Return a sphere that a vehicle of such a speed, north, does not run into."""
    radius, velocity, nearest_m = rng.uniform(*RADII_M), np.zeros(2), 0.0
    while nearest_m < radius + CLEAR_M:
        place = rng.uniform(*AHEAD_M) * np.array([1.0, rng.uniform(-ASIDE, ASIDE)])
        if name == MOVER:
            velocity = np.array([rng.uniform(-0.5, 0.3), rng.choice([-1.0, 1.0]) * rng.uniform(0.3, 0.9)])
        way = place + np.linspace(0.0, SECONDS, 100)[:, None] * (velocity - (speed, 0.0))
        nearest_m = float(np.hypot(*way.T).min())
    below = depth_m - place[0] * math.tan(math.radians(bed.rises_deg))
    down = min(max(below - rng.uniform(*HEIGHTS_M), SHALLOWEST_M), DEEPEST_M)
    rows = f"velocity_ned = [{velocity[0]:.2f}, {velocity[1]:.2f}, 0.0]\nradius_m = {radius:.2f}"
    return object_text("sphere", name, place, down, rows, SPHERE)


def main() -> None:
    """Write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--each", type=int, default=3, help="of each kind of bed")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    rng = np.random.default_rng(args.seed)
    args.folder.mkdir(parents=True, exist_ok=True)
    for name, bed in BEDS.items():
        for number in range(args.each):
            (args.folder / f"{name}{number}.toml").write_text(scene_text(bed, rng), encoding="utf-8")


if __name__ == "__main__":
    main()
