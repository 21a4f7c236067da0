"""What the simulator's error budget holds: random scenes against a plain sum over small pieces of their surfaces.

    python -m benchmarks.simulator.budget [scenes of each kind]

Nothing of the simulator is used in the sums: eqs. 3 to 5 of [SSIE], the vertical pattern's table, a sum over the
elements of the array, straight lines for what hides what.
"""

import sys
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.ndimage import uniform_filter
from scipy.optimize import brentq

from ods.base.arrays import Floats, Mask
from ods.sim_sonar.echo.bodies.bodies import BODY, CYLINDER, PLANE, SPHERE, Bodies, Body
from ods.sim_sonar.mean_area import Surroundings, mean_area
from ods.sim_sonar.pose import VehiclePose
from ods.sim_sonar.sonar.grid import grid_of
from ods.sim_sonar.sonar.model import SonarModel, make_sonar
from ods.sim_sonar.sonar.settings import SonarFile, VerticalPattern

SEABAT = SonarFile(name="SeaBat 6012", frequency_hz=455e3, beams_per_plane=60, beam_spacing_deg=1.5, beam_width_deg=1.5,
                   range0_m=0.05, dr_m=0.05, samples=2000)  # fmt: skip
HERE = VehiclePose(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
KINDS = {"spheres": SPHERE, "cylinders": CYLINDER, "planes": PLANE}
SMOOTHING = (3, 9)
"""Beams and samples of the mean after which the budget holds."""
TABLE_STEP, TABLE_END = 0.02, 125.0
"""Beam widths."""
BEARINGS_PER_WIDTH = 16
"""Bearings in one beam width that the sum tells apart."""
STEP_M = 0.04
"""Greatest side of a piece of surface; there are 100 pieces along each side at least."""


class Pieces(NamedTuple):
    """Small pieces of a surface, in the sonar's frame."""

    place: Floats
    """(n, 3) m."""
    normal: Floats
    """(n, 3) outwards; of a plane towards the sonar."""
    area: Floats
    """(n,) m2."""


def scene_of(kind: int, seed: int, farthest_m: float = 92.0) -> Bodies:
    """Return one to three random bodies of a kind ahead of the sonar, whose middles are nearer than `farthest_m`."""
    rng = np.random.default_rng([kind, seed])
    bodies = np.zeros(int(rng.integers(1, 4)), BODY)
    for body in bodies:
        bearing, elevation = rng.uniform(-0.85, 0.85), rng.uniform(-0.2, 0.2)
        toward = [np.cos(bearing) * np.cos(elevation), np.sin(bearing) * np.cos(elevation), -np.sin(elevation)]
        sides = 10.0 ** rng.uniform(-0.6, 0.7, 2)
        body["kind"], body["half"] = kind, (sides[0], sides[0], sides[0])
        if kind == CYLINDER:
            body["half"] = (0.4 * sides[0], 0.4 * sides[0], sides[1])
        elif kind == PLANE:
            body["half"] = (sides[0], sides[1], 0.0)
        body["centre"] = np.array(toward) * rng.uniform(8.0 + 1.5 * np.hypot(*sides), farthest_m)
        body["axes"] = np.linalg.qr(rng.standard_normal((3, 3)))[0]
        body["cd"], body["cs"], body["sigma_rad"] = *rng.uniform(0.1, 0.6, 2), np.radians(rng.uniform(5.0, 30.0))
    return bodies


def summed(bodies: Bodies, file: SonarFile, step_m: float = STEP_M) -> Floats:
    """Return the mean area, m2, (beams, samples), that a sonar at the origin receives of bodies in its frame."""
    rng = np.random.default_rng(1)
    width = np.radians(file.beam_width_deg)
    edges = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 1 + round(np.pi / width * BEARINGS_PER_WIDTH))
    bins = file.range0_m + file.dr_m * (np.arange(file.samples + 1) - 0.5)
    received = np.zeros((len(edges) - 1, file.samples))
    for which, body in enumerate(bodies):
        for pieces in _pieces_of(body, step_m, rng):
            seen = np.ones(len(pieces.area), np.bool_)
            for other in np.delete(bodies, which):
                seen &= ~hides(other, pieces.place)
            distance = np.linalg.norm(pieces.place, axis=1)
            echo = np.where(seen, echo_of(body, pieces, distance, file.vertical), 0.0)
            bearing = np.arctan2(pieces.place[:, 1], pieces.place[:, 0])
            received += np.histogram2d(bearing, distance, (edges, bins), weights=echo)[0]
    beams = np.radians((np.arange(file.beams_per_plane) - 0.5 * (file.beams_per_plane - 1)) * file.beam_spacing_deg)
    offset = (0.5 * (edges[1:] + edges[:-1]) - beams[:, None]) / width
    return np.asarray(array_pattern(offset, file.side_lobe_db) @ received)


def echo_of(body: Body, pieces: Pieces, distance: Floats, vertical: VerticalPattern) -> Floats:
    """Return gamma S^2 cos(alpha) dA, m2, (n,), of pieces at these distances, 0 of those that look away."""
    facing = -np.sum(pieces.normal * pieces.place, axis=1) / distance
    cosine = np.clip(facing, 1e-9, 1.0)
    lobe = np.exp(-0.5 * np.square(np.arccos(cosine) / body["sigma_rad"]))
    gamma = body["cd"] * cosine + body["cs"] * np.minimum(1.0, 2.0 * cosine**2) * lobe / cosine
    off_axis = np.degrees(np.abs(np.arcsin(pieces.place[:, 2] / distance)))
    two_way = 10.0 ** (np.interp(off_axis, vertical.angle_deg, vertical.level_db) / 10.0)
    return np.asarray(np.where(facing > 0.0, gamma * two_way * cosine * pieces.area, 0.0))


def array_pattern(offset: Floats, side_lobe_db: float) -> Floats:
    """Return the power that a line array with a Kaiser-Bessel taper receives, at `offset` beam widths off its axis."""
    table = _pattern_table(side_lobe_db)
    return np.interp(np.abs(offset), TABLE_STEP * np.arange(len(table)), table)


@cache
def _pattern_table(side_lobe_db: float) -> Floats:
    """Return the sum over the array's elements, squared, each TABLE_STEP of a beam width."""
    elements = (np.arange(600) + 0.5) / 600.0
    taper = brentq(lambda b: 20.0 * np.log10(np.sinh(b) / b) + 13.26 + side_lobe_db, 0.1, 12.0)
    weight = np.i0(taper * np.sqrt(1.0 - elements**2))
    weight /= weight.sum()
    half = brentq(lambda u: float(np.cos(u * elements) @ weight) - np.sqrt(0.5), 0.1, 5.0)
    offset = TABLE_STEP * np.arange(round(TABLE_END / TABLE_STEP))
    return np.asarray(np.square(np.cos(np.multiply.outer(2.0 * half * offset, elements)) @ weight), np.float64)


def hides(body: Body, place: Floats) -> Mask:
    """Tell, (n,), whether a body is met on the straight lines from the sonar to places (n, 3)."""
    half, axes = body["half"], body["axes"]
    start, way = -axes @ body["centre"], place @ axes.T
    if body["kind"] == PLANE:
        share = -start[2] / np.where(way[:, 2] == 0.0, np.nan, way[:, 2])
        x, y = (np.abs(start[k] + share * way[:, k]) < half[k] for k in range(2))
        return np.asarray((share > 0.0) & (share < 1.0) & x & y)
    round_ = slice(0, 3 if body["kind"] == SPHERE else 2)
    a, b = np.square(way[:, round_]).sum(axis=1), way[:, round_] @ start[round_]
    root = b * b - a * (start[round_] @ start[round_] - half[0] ** 2)
    met = root > 0.0
    begin, end = ((-b + side * np.sqrt(np.maximum(root, 0.0))) / a for side in (-1.0, 1.0))
    if body["kind"] == CYLINDER:
        first, last = ((-start[2] + side * half[2] * np.sign(way[:, 2])) / way[:, 2] for side in (-1.0, 1.0))
        begin, end = np.maximum(begin, first), np.minimum(end, last)
    return np.asarray(met & (begin < end) & (end > 0.0) & (begin < 1.0))


def _pieces_of(body: Body, step_m: float, rng: np.random.Generator) -> Iterator[Pieces]:
    """Yield the pieces of a body's surfaces, each sampled anywhere in its piece."""
    half, turn = body["half"], 2.0 * np.pi
    if body["kind"] == PLANE:
        u, v, area = _even(2.0 * half[0], 2.0 * half[1], step_m, rng)
        place = np.stack([u - half[0], v - half[1], 0.0 * u], axis=1)
        up = np.tile([0.0, 0.0, -np.sign(body["axes"][2] @ body["centre"])], (len(u), 1))
        yield _placed(body, place, up, np.full(len(u), area))
    elif body["kind"] == SPHERE:
        u, v, area = _even(turn * half[0], 2.0 * half[0], step_m, rng)  # Archimedes: even in height is even in area
        z = v / half[0] - 1.0
        level = np.sqrt(1.0 - z * z)
        unit = np.stack([level * np.cos(u / half[0]), level * np.sin(u / half[0]), z], axis=1)
        yield _placed(body, half[0] * unit, unit, np.full(len(u), area))
    else:
        u, v, area = _even(turn * half[0], 2.0 * half[2], step_m, rng)
        unit = np.stack([np.cos(u / half[0]), np.sin(u / half[0]), 0.0 * u], axis=1)
        yield _placed(body, half[0] * unit + np.outer(v - half[2], [0.0, 0.0, 1.0]), unit, np.full(len(u), area))
        for side in (-1.0, 1.0):
            u, v, area = _even(turn * half[0], half[0], step_m, rng)
            place = np.stack([v * np.cos(u / half[0]), v * np.sin(u / half[0]), 0.0 * u + side * half[2]], axis=1)
            yield _placed(body, place, np.tile([0.0, 0.0, side], (len(u), 1)), area * v / half[0])


def _even(width: float, height: float, step_m: float, rng: np.random.Generator) -> tuple[Floats, Floats, float]:
    """Return two coordinates, (n,), one place in each piece of a rectangle, and the area of a piece."""
    across, along = (max(100, int(np.ceil(side / step_m))) for side in (width, height))
    u = (np.arange(across)[:, None] + rng.random((across, along))) * (width / across)
    v = (np.arange(along) + rng.random((across, along))) * (height / along)
    return u.ravel(), v.ravel(), width * height / (across * along)


def _placed(body: Body, place: Floats, normal: Floats, area: Floats) -> Pieces:
    return Pieces(place @ body["axes"] + body["centre"], normal @ body["axes"], area)


def smoothed_error(image: Floats, reference: Floats) -> float:
    """Return the rms of the difference of two images after a mean over SMOOTHING, over that of the second."""
    off, whole = uniform_filter(image - reference, SMOOTHING), uniform_filter(reference, SMOOTHING)
    return float(np.linalg.norm(off) / np.linalg.norm(whole))


def error_of(bodies: Bodies, reference: Floats, sonar: SonarModel, max_error: float) -> float:
    """Return the smoothed error of the simulator's image of bodies in the sonar's frame."""
    return smoothed_error(mean_area(grid_of(sonar), Surroundings(bodies), HERE, max_error), reference)


def main() -> None:
    """Print the share of random scenes within the budget."""
    count, sonar = int(sys.argv[1]) if len(sys.argv) > 1 else 40, make_sonar(SEABAT)
    print("| objects | max_error | within | median | 95 % | 99 % | worst |\n|---|---|---|---|---|---|---|")
    for name, kind in KINDS.items():
        scenes = [scene_of(kind, seed) for seed in range(count)]
        references = [summed(scene, SEABAT) for scene in scenes]
        for max_error in (0.1, 0.03, 0.01):
            errors = np.array([error_of(*pair, sonar, max_error) for pair in zip(scenes, references, strict=True)])
            reported = np.quantile(errors, [0.5, 0.95, 0.99, 1.0])
            quantiles = " | ".join(f"{error:.1%}" for error in reported)
            print(f"| {name} | {max_error} | {np.mean(errors <= max_error):.0%} | {quantiles} |", flush=True)


if __name__ == "__main__":
    main()
