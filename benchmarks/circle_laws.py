"""`python -m benchmarks.circle_laws ods/pipeline/measure/laws.py`: fit the laws of circles, and write them as a module.

Bodies of the kinds of benchmarks/circles.py, drawn at random, are looked at through the default chain. Of what is
found, two laws are fitted (fitted_layers.py):

- BODY: how likely each kind is, by its logarithmic loss; a body's radius over its echo's depth if it is of a kind, and
  how far from the echo's edge it begins, by Huber's loss;
- SIGMAS: the variances of the errors that are left, by a gamma regression of their squares. One variance is right for
  all that looks alike on average only. Sorts of bodies, by kind, level and radius, whose squared errors are more than
  claimed are counted more, a few times over, so that none is claimed to be much better known than it is.
"""

import argparse
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple
from unittest.mock import patch

import numpy as np

from benchmarks.circles import RADII_M, Case, Look, drawn, looks
from benchmarks.fitted_layers import (
    MOST_SQUARE,
    Layers,
    Loss,
    beginning,
    distance_loss,
    fitted,
    kind_loss,
    variance_loss,
)
from ods.base.arrays import Floats, Image
from ods.pipeline import prepared_chain
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.recorded import Recorded
from ods.pipeline.image.regions import Regions
from ods.pipeline.measure.circle import circle_of
from ods.pipeline.measure.echoes import ECHO, EchoTable, measure_echoes, shape_at
from ods.pipeline.measure.features import Features, features_of
from ods.pipeline.measure.kinds import body_of, shift_of
from ods.pipeline.measure.response import point_width
from ods.pipeline.measure.shape import Shape
from ods.pipeline.settings import PipelineSettings

SHARES = {"front": 0.4, "disc": 0.2, "half": 0.12, "plate": 0.2, "point": 0.08}
KIND = {"front": 0, "disc": 1, "half": 2, "plate": 3, "point": 3}
"""Row of the laws."""
SNR_DB = (5.0, 27.0)
BODY_RIDGE, BODY_ROUNDS = 1e-3, 500
SIGMAS_RIDGE, SIGMAS_ROUNDS = 3e-3, 300
RATIO_COUNTS, BEND = 4.0, 0.5
"""How much the logarithm of a radius counts, and from which error on it counts less."""
SORT_LEVELS_DB, SORT_RADII_M = (8.0, 12.0, 18.0), (0.7, 2.0)
"""Borders between sorts of bodies."""
SORT_ROUNDS, SORT_STEP, SORT_WEIGHTS, LEAST_OF_A_SORT = 2, (0.7, 3.0), (0.3, 6.0), 15
LINE = 110
"""Characters of a line of laws.py."""
HEAD = '''\
"""The laws of circles, not written by hand: `python -m benchmarks.circle_laws ods/pipeline/measure/laws.py`."""

import numpy as np

from ods.base.arrays import Floats

# fmt: off
'''


class Seen(NamedTuple):
    """A body, and what its echo shows."""

    look: Look
    shape: Shape
    features: Features


def cases(count: int, rng: np.random.Generator) -> Iterator[Case]:
    """Draw bodies, weak ones more often than strong ones, and every other one with a radius drawn evenly.

    What is seldom, such as a large body of which little is seen, is otherwise not held by the standard deviations.
    """
    least, most = SNR_DB
    for kind in rng.choice(list(SHARES), count, p=list(SHARES.values())):
        case = drawn(str(kind), least + (most - least) * float(rng.random()) ** 1.5, rng)
        evenly = case.size > 0.0 and rng.random() < 0.5
        yield case._replace(size=float(rng.uniform(*RADII_M))) if evenly else case


def seen_of(chain: Chain, bodies: Iterator[Case], rng: np.random.Generator) -> Iterator[Seen]:
    """Look at each body once; what is not found is left out."""
    shapes: dict[tuple[float, float], Shape] = {}

    def listening(image: Image, regions: Regions, recorded: Recorded, fan: Fan) -> EchoTable:
        speckle = regions.background, point_width(image, regions.background)
        for k in range(regions.total):
            runs = regions.runs[regions.runs["region"] == k + 1]
            shape = shape_at(image, runs, speckle, fan.table, np.zeros(1, ECHO)[0])
            shapes[circle_of(shape).near_m, shape.bearing_rad] = shape
        return measure_echoes(image, regions, recorded, fan)

    with patch.object(prepared_chain, "measure_echoes", listening):
        for case in bodies:
            shapes.clear()
            (look,) = looks(chain, case, 1, rng)
            if look.found:
                shape = shapes[look.found.near_m, look.found.bearing_rad]
                yield Seen(look, shape, features_of(shape))


def laws_of(seen: list[Seen], rng: np.random.Generator) -> dict[str, Layers]:
    """Return the laws by their names in laws.py."""
    inputs = np.array([s.features for s in seen])
    body = fitted(
        inputs, body_loss(seen), beginning(inputs, 8, rng), np.ones(len(seen)), BODY_RIDGE, BODY_ROUNDS
    )  # fmt: skip
    told = body.outputs(inputs)
    error = np.array([errors(s, row) for s, row in zip(seen, told, strict=True)])
    return {"BODY": body, "SIGMAS": sigmas_of(seen, inputs, error, rng)}


def body_loss(seen: list[Seen]) -> Loss:
    """Return the loss of what `body_of` is told: of the kind, of the radius if it is that kind, of the near edge."""
    kind = np.array([KIND[s.look.case.kind] for s in seen])
    depth = [s.shape.depth for s in seen]
    long = np.array([max(d.far_m - d.near_m, 0.25 * d.point_m) for d in depth])
    ratio = np.log(np.maximum([s.look.case.size for s in seen], 0.05) / long)
    shift = np.array([(s.look.near_m - d.near_m) / shift_of(d) for s, d in zip(seen, depth, strict=True)])
    likely = kind_loss(kind, 4)
    counts = np.column_stack((RATIO_COUNTS * np.eye(4)[kind][:, :3], np.ones(len(seen))))
    distance = distance_loss(np.column_stack((ratio, ratio, ratio, shift)), counts, BEND)

    def loss(outputs: Floats) -> tuple[Floats, Floats]:
        (first, first_slope), (second, second_slope) = likely(outputs[:, :4]), distance(outputs[:, 4:])
        return first + second, np.column_stack((first_slope, second_slope))

    return loss


def sigmas_of(seen: list[Seen], inputs: Floats, error: Floats, rng: np.random.Generator) -> Layers:
    """Return the law of the variances. Sorts of bodies whose errors are larger than claimed count more and more."""
    sorts = np.array([sort_of(s.look.case) for s in seen])
    weights, loss = np.ones(len(seen)), variance_loss(error)
    law = fitted(inputs, loss, beginning(inputs, 4, rng), weights, SIGMAS_RIDGE, SIGMAS_ROUNDS)
    for _ in range(SORT_ROUNDS):
        square = np.minimum(error**2 / np.exp(law.outputs(inputs)), MOST_SQUARE)
        for sort in np.unique(sorts):
            same = sorts == sort
            if same.sum() >= LEAST_OF_A_SORT:
                weights[same] *= np.sqrt(np.clip(square[same].mean(0).max(), *SORT_STEP))
        weights = np.clip(weights / weights.mean(), *SORT_WEIGHTS)
        law = fitted(inputs, loss, law, weights, SIGMAS_RIDGE, SIGMAS_ROUNDS // 4)
    return law


def sort_of(case: Case) -> int:
    """Return a number for bodies of the same kind, and about the same level and radius."""
    level, size = np.digitize(case.snr_db, SORT_LEVELS_DB), np.digitize(case.size, SORT_RADII_M)
    return int(100 * list(SHARES).index(case.kind) + 10 * level + size)


def errors(seen: Seen, told: Floats) -> tuple[float, float, float, float]:
    """Return the errors of near edge, range, radius and place across, in widths of a point."""
    (_, size, range_m, _), bearing, near_m, _ = seen.look
    body = body_of(seen.shape, told)
    across = (seen.shape.bearing_rad - bearing) * range_m
    wrong = (body.near_m - near_m, body.near_m + body.behind_m - range_m, body.radius_m - size, across)
    near, centre, radius, beside = (value / seen.shape.depth.point_m for value in wrong)
    return near, centre, radius, beside


def module_of(laws: dict[str, Layers]) -> str:
    """Return the text of laws.py."""
    text = HEAD
    for name, law in laws.items():
        for part, factors in zip(("HIDDEN", "OUT"), law, strict=True):
            text += f"{name}_{part}: Floats = np.array([\n" + "".join(map(_row, factors)) + "])\n"
    return text


def _row(factors: Floats) -> str:
    """Return the lines of a row of factors."""
    row = "[" + ", ".join(f"{value:.4g}" for value in factors) + "],"
    return textwrap.indent(textwrap.fill(row, LINE, break_long_words=False, break_on_hyphens=False), "    ") + "\n"


def main() -> None:
    """Write the laws."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("module", type=Path, help="the file that is written")
    parser.add_argument("--bodies", type=int, default=12000, help="that are drawn")
    parser.add_argument("--seed", type=int, default=6)
    args = parser.parse_args()
    rng = np.random.default_rng(args.seed)
    seen = list(seen_of(Chain(PipelineSettings()), cases(args.bodies, rng), rng))
    args.module.write_text(module_of(laws_of(seen, np.random.default_rng([args.seed, 1]))))
    print(f"{args.module}: {len(seen)} of {args.bodies} bodies found")


if __name__ == "__main__":
    main()
