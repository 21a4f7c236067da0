"""`python -m benchmarks.circles.laws`: fit the laws of circles' sigmas, and write them.

Bodies of the kinds of benchmarks/circles/synthetic.py are drawn at random and looked at through the default chain, by
fans of wide beams and, at short ranges, of fine ones; some images have little speckle, as sonars that average theirs,
or none. To the squared errors of what is found, biases and all, variances are fitted that depend on an echo's features
(fitted_layers.py). They are right on average over all that looks alike. No draw is one of
benchmarks/circles/synthetic.py: seeds have one number or two here, and four or five there.

To the range's law spheres over sea-beds (bed_spheres.py) count as well, each echo as one over speckle. To the law of
near edge, radius and place across they do not: of spheres over these beds alone it would claim too little.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.circles.bed_spheres import seen_over_beds
from benchmarks.circles.fitted_layers import Layers, beginning, fitted
from benchmarks.circles.heard_echoes import Seen, received
from benchmarks.circles.synthetic import RADII_M, RANGES_M, SONAR, Case, Sonar, looks
from ods.base.arrays import Floats
from ods.pipeline.chain import Chain
from ods.pipeline.measure.echoes import SIGMA_NETWORK
from ods.pipeline.settings import PipelineSettings

SHARES = {"front": 0.3, "disc": 0.2, "half": 0.12, "plate": 0.18, "point": 0.2}
SPECKLE = {1: 0.8, 4: 0.1, 1_000_000: 0.1}
"""How many images are averaged, and how often."""
SNR_DB = (5.0, 27.0)


class Scene(NamedTuple):
    """A fan, and the bodies that are drawn before it."""

    share: float
    """Of all."""
    sonar: Sonar
    radii_m: tuple[float, float]
    ranges_m: tuple[float, float]


SCENES = (
    Scene(0.7, SONAR, RADII_M, RANGES_M),
    Scene(0.1, Sonar(128, 1200, float(np.radians(0.23)), 0.01), (0.05, 0.4), (1.5, 10.0)),
    Scene(0.1, Sonar(128, 700, float(np.radians(0.3)), 0.02), (0.05, 0.5), (2.0, 12.0)),
    Scene(0.1, Sonar(100, 1200, float(np.radians(0.7)), 0.04), (0.1, 3.0), (5.0, 40.0)),
)
RIDGE, ROUNDS = 1e-3, 400
CLAIMED, RANGE = [0, 2, 3], [1]
"""Which of the errors the two laws are of."""
WITHOUT_CONTRAST = -1
"""Features of the first of them: all but the last one."""


def scenes(rng: np.random.Generator, count: int) -> Iterator[tuple[int, Case, int]]:
    """Draw bodies, with the number of their scene and how many images are averaged; more weak ones than strong ones.

    Weak points are not found, so of those it is the other way round. Every other body has a radius drawn evenly, the
    others by the logarithm: what is seldom, such as a large body of which little is seen, is otherwise not held by the
    standard deviations.
    """
    least, most = SNR_DB
    for _ in range(count):
        number = int(rng.choice(len(SCENES), p=[scene.share for scene in SCENES]))
        scene = SCENES[number]
        kind = str(rng.choice(list(SHARES), p=list(SHARES.values())))
        size = rng.uniform(*scene.radii_m) if rng.random() < 0.5 else np.exp(rng.uniform(*np.log(scene.radii_m)))
        point, speckle = kind == "point", int(rng.choice(list(SPECKLE), p=list(SPECKLE.values())))
        range_m, snr_db = rng.uniform(*scene.ranges_m), least + (most - least) * rng.random() ** (0.5 if point else 1.5)
        yield number, Case(kind, 0.0 if point else float(size), float(range_m), float(snr_db), scene.sonar), speckle


def seen_of(rng: np.random.Generator, count: int) -> Iterator[Seen]:
    """Look at bodies once each; those that are not found are left out."""
    chains = [Chain(PipelineSettings()) for _ in SCENES]
    with received() as reported:
        for number, case, speckle in scenes(rng, count):
            reported.forget()
            (look,) = looks(chains[number], case, 1, rng, speckle)
            if look.found and not look.found.cut:
                yield reported.seen(look, look.found)


class Laws(NamedTuple):
    """What laws.npz holds."""

    sigmas: Layers
    """Of near edge, radius and place across."""
    range: Layers


def laws_of(seen: list[Seen], over_beds: list[Seen], rng: np.random.Generator) -> Laws:
    """Return the laws of the variances. The first is fitted to all four errors: what they share steadies its layer."""
    inputs, error = np.array([s.features for s in seen]), np.array([errors(s) for s in seen])
    hidden, out = _law(inputs[:, :WITHOUT_CONTRAST], error, rng)
    more = np.vstack((inputs, [s.features for s in over_beds]))
    along = np.vstack((error, [errors(s) for s in over_beds]))[:, RANGE]
    return Laws(Layers(hidden, out[:, CLAIMED]), _law(more, along, rng))


def _law(inputs: Floats, error: Floats, rng: np.random.Generator) -> Layers:
    return fitted(inputs, error, beginning(inputs, error.shape[1], rng), RIDGE, ROUNDS)


def errors(seen: Seen) -> tuple[float, float, float, float]:
    """Return the errors of near edge, range, radius and place across, in widths of a point."""
    (_, size, range_m, *_), bearing, near_m, found = seen.look
    assert found
    across = (found.bearing_rad - bearing) * range_m
    wrong = found.near_m - near_m, found.range_m - range_m, found.radius_m - size, across
    near, centre, radius, beside = (value / seen.point_m for value in wrong)
    return near, centre, radius, beside


def save(laws: Laws, path: Path) -> None:
    """Write laws.npz."""
    np.savez(path, **{f"{name}_{part}": getattr(law, part) for name, law in laws._asdict().items()
                      for part in Layers._fields})  # fmt: skip


def main() -> None:
    """Write the laws."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=SIGMA_NETWORK, metavar="LAWS.npz", help="the file that is written")
    parser.add_argument("--bodies", type=int, default=16000, help="that are drawn")
    parser.add_argument("--beds", type=int, default=160, help="scenes with spheres that are drawn")
    parser.add_argument("--seed", type=int, default=6)
    args = parser.parse_args()
    seen = list(seen_of(np.random.default_rng(args.seed), args.bodies))
    over_beds = list(seen_over_beds(np.random.default_rng([args.seed, 2]), args.beds))
    save(laws_of(seen, over_beds, np.random.default_rng([args.seed, 1])), args.out)
    print(f"{args.out}: {len(seen)} of {args.bodies} bodies found, {len(over_beds)} echoes over sea-beds")


if __name__ == "__main__":
    main()
