"""`python -m benchmarks.circle_laws ods/pipeline/measure/laws.py`: fit the law of circles' sigmas, and write it.

Bodies of the kinds of benchmarks/circles.py are drawn at random and looked at through the default chain, by fans of
wide beams and, at short ranges, of fine ones; some images have little speckle, as sonars that average theirs, or none.
To the squared errors of what is found, biases and all, variances are fitted that depend on an echo's features
(fitted_layers.py). They are right on average over all that looks alike. No draw is one of benchmarks/circles.py: seeds
have one number or two here, and four or five there.
"""

import argparse
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

from benchmarks.circles import RADII_M, RANGES_M, SONAR, Case, Look, Sonar, looks
from benchmarks.fitted_layers import Layers, beginning, fitted
from ods.base.arrays import Floats, Image
from ods.pipeline import prepared_chain
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.recorded import Recorded
from ods.pipeline.image.regions import Regions
from ods.pipeline.measure.echoes import ECHO, EchoTable, measure_at, measure_echoes
from ods.pipeline.measure.features import Features
from ods.pipeline.measure.response import point_width
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
CLAIMED = [0, 2, 3]
"""Which of the errors the law is written for: not that of the range (docs/pipeline.md, Circles)."""
LINE = 110
"""Characters of a line of laws.py."""
HEAD = '''\
"""The law of circles' sigmas, not written by hand: `python -m benchmarks.circle_laws ods/pipeline/measure/laws.py`."""

import numpy as np

from ods.base.arrays import Floats

# fmt: off
'''


class Seen(NamedTuple):
    """A body of which an echo was found."""

    look: Look
    point_m: float
    """Width of a point along the line of sight."""
    features: Features


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
    features: dict[tuple[float, float], tuple[float, Features]] = {}

    def listening(image: Image, regions: Regions, recorded: Recorded, fan: Fan) -> EchoTable:
        point = point_width(image, regions.background)
        for k in range(regions.total):
            runs, echo = regions.runs[regions.runs["region"] == k + 1], np.zeros(1, ECHO)[0]
            told = Features(*measure_at(image, runs, (regions.background, point), fan.table, echo)[0])
            features[float(echo["near_m"]), float(echo["bearing_rad"])] = point * fan.dr_m, told
        return measure_echoes(image, regions, recorded, fan)

    with patch.object(prepared_chain, "measure_echoes", listening):
        for number, case, speckle in scenes(rng, count):
            features.clear()
            (look,) = looks(chains[number], case, 1, rng, speckle)
            if look.found and not look.found.cut:
                yield Seen(look, *features[look.found.near_m, look.found.bearing_rad])


def law_of(seen: list[Seen], rng: np.random.Generator) -> Layers:
    """Return the law of the variances."""
    inputs, error = np.array([s.features for s in seen]), np.array([errors(s) for s in seen])
    return fitted(inputs, error, beginning(inputs, error.shape[1], rng), RIDGE, ROUNDS)


def errors(seen: Seen) -> tuple[float, float, float, float]:
    """Return the errors of near edge, range, radius and place across, in widths of a point."""
    (_, size, range_m, *_), bearing, near_m, found = seen.look
    assert found
    across = (found.bearing_rad - bearing) * range_m
    wrong = found.near_m - near_m, found.range_m - range_m, found.radius_m - size, across
    near, centre, radius, beside = (value / seen.point_m for value in wrong)
    return near, centre, radius, beside


def module_of(law: Layers) -> str:
    """Return the text of laws.py."""
    text = HEAD
    for part, factors in (("HIDDEN", law.hidden), ("OUT", law.out[:, CLAIMED])):
        text += f"SIGMAS_{part}: Floats = np.array([\n" + "".join(map(_row, factors)) + "])\n"
    return text


def _row(factors: Floats) -> str:
    """Return the lines of a row of factors."""
    row = "[" + ", ".join(f"{value:.4g}" for value in factors) + "],"
    return textwrap.indent(textwrap.fill(row, LINE, break_long_words=False, break_on_hyphens=False), "    ") + "\n"


def main() -> None:
    """Write the law."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("module", type=Path, help="the file that is written")
    parser.add_argument("--bodies", type=int, default=16000, help="that are drawn")
    parser.add_argument("--seed", type=int, default=6)
    args = parser.parse_args()
    seen = list(seen_of(np.random.default_rng(args.seed), args.bodies))
    args.module.write_text(module_of(law_of(seen, np.random.default_rng([args.seed, 1]))))
    print(f"{args.module}: {len(seen)} of {args.bodies} bodies found")


if __name__ == "__main__":
    main()
