"""Bodies cut off by the farthest range or by the shadow of a nearer one: is the place of their tracks as good as told?

The scenes, the counting and the columns are those of `benchmarks.tracker.fan_edge`, with eight spheres at the farthest
range of a SeaBat 6012, which move along the line of sight at 0.3, 0.7 and 1.5 m/s or are passed by the vehicle (lists
while the border of range runs through them), and four spheres of 1.5 and 3 m of which a nearer one hides about one
half, at rest, while the vehicle hovers or sways (all lists of 13 s). `python -m benchmarks.tracker.seen_in_part [--runs
N]`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.tracker.fan_edge import CROSSES_S, RADII_M, line, runs_of, table_of
from ods.messages import Truth, TruthObject

FARTHEST_M = 100.025
FAR_DEG = (-36.0, -25.0, -14.0, -4.0, 7.0, 18.0, 29.0, 40.0)
HIDDEN_DEG = (-33.0, -11.0, 11.0, 33.0)
FRONTS = ((20.0, 1.5), (30.0, 3.0), (25.0, 2.0), (35.0, 2.0))
"""Range and radius of those in front, m."""
IMAGE = "[image]\ngain = 20000.0\nnoise_counts = 30.0\nlooks = 1.0\n"


@dataclass(frozen=True)
class Case:
    """What moves."""

    name: str
    text: Callable[["Case", int], str]
    """The scene of a seed."""
    object_speed: float = 0.0
    """m/s, along the line of sight, half of them outwards."""
    ahead: float = 0.0
    """Of the vehicle, m/s,"""
    aside: float = 0.0
    """and to starboard."""


def sphere(name: str, place: tuple[float, float], radius: float, velocity: tuple[float, float] = (0.0, 0.0)) -> str:
    """Return the entry of a sphere at the sonar's depth."""
    return (
        f'[[objects]]\nshape = "sphere"\nname = "{name}"\nradius_m = {radius}\n'
        f"position_ned = [{place[0]}, {place[1]}, 4.0]\nvelocity_ned = [{velocity[0]}, {velocity[1]}, 0.0]\n"
        "surface = { cd = 0.1, cs = 0.05, sigma_deg = 15.0 }\n"
    )


def at_farthest_range(case: Case, seed: int) -> str:
    """Return a scene of eight spheres that cross the farthest range halfway."""
    items = ""
    for k, degrees in enumerate(FAR_DEG):
        outwards = (k + seed // 2) % 2 == 0 if case.object_speed else case.ahead < 0.0
        bearing, speed, radius = math.radians(degrees), case.object_speed, RADII_M[(k + seed) % 3]
        north, east = math.cos(bearing), math.sin(bearing)
        along = speed if outwards else -speed
        place = FARTHEST_M * north - CROSSES_S * along * north, FARTHEST_M * east - CROSSES_S * along * east
        place = place[0] + CROSSES_S * case.ahead, place[1]
        name = f"{'out' if outwards else 'in'}/{radius}/{k + 1}"
        items += sphere(name, place, radius, (along * north, along * east))
    vehicle = f"[vehicle]\nposition_ned = [0.0, 0.0, 4.0]\nvelocity_ned = [{case.ahead}, 0.0, 0.0]\n"
    return f"seed = {seed}\nduration_s = {2.0 * CROSSES_S}\nshadows = false\n{vehicle}{items}{IMAGE}"


def in_shadows(case: Case, seed: int) -> str:
    """Return a scene of four spheres about whose middles the border of a nearer one's shadow runs."""
    rng, items = np.random.default_rng(seed), ""
    for k, degrees in enumerate(HIDDEN_DEG):
        odd = (k + seed) % 2
        (near_m, front), radius = FRONTS[(k + seed) % 4], RADII_M[1 + odd]
        range_m, bearing = near_m + 15.0 + 10.0 * odd, math.radians(degrees)
        aside = math.asin(front / near_m) + rng.uniform(-0.5, 0.5) * radius / range_m
        beside = bearing + (aside if odd else -aside)
        items += sphere(f"front/{front}/{k}", (near_m * math.cos(bearing), near_m * math.sin(bearing)), front)
        items += sphere(f"hidden/{radius}/{k}", (range_m * math.cos(beside), range_m * math.sin(beside)), radius)
    start = -0.5 * case.aside * CROSSES_S
    vehicle = f"[vehicle]\nposition_ned = [0.0, {start}, 4.0]\nvelocity_ned = [0.0, {case.aside}, 0.0]\n"
    return f"seed = {seed}\nduration_s = {CROSSES_S}\nshadows = true\n{vehicle}{items}{IMAGE}"


CASES = (
    *(Case(f"farthest range, object {v} m/s", at_farthest_range, object_speed=v) for v in (0.3, 0.7, 1.5)),
    Case("farthest range, vehicle 1.5 m/s", at_farthest_range, ahead=1.5),
    Case("farthest range, vehicle -1 m/s", at_farthest_range, ahead=-1.0),
    Case("shadow, vehicle hovers", in_shadows),
    Case("shadow, vehicle sways 0.5 m/s", in_shadows, aside=0.5),
)


def counts(truth: Truth, item: TruthObject) -> bool:
    """Tell whether a part of the object is hidden now."""
    way = item.name.split("/")[0]
    if way in ("hidden", "front"):
        return way == "hidden"
    away = math.hypot(*(item.position_ned[k] - truth.position_ned[k] for k in (0, 1)))
    return abs(away - FARTHEST_M) < item.radius_m + 0.3


def main() -> None:
    """Run all cases and print the table."""
    runs = runs_of(__doc__)
    found = table_of(((case.name, case.text(case, seed)) for case in CASES for seed in range(runs)), counts)
    for kind in ("farthest range", "shadow"):
        for size in RADII_M:
            each = [one for name, one in found.items() if name.startswith(kind) and name.endswith(f"{size} m")]
            if any(one.nees for one in each):
                print(line(f"all, {kind}, {size} m", each))
        print(line(f"all, {kind}", [one for name, one in found.items() if name.startswith(kind)]))


if __name__ == "__main__":
    main()
