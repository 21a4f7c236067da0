"""Levels that follow the background, by several methods: `python -m benchmarks.level_methods`.

False echoes on K-distributed clutter and sea-beds at the level that has one an image of speckle; what it costs on
speckle; bodies found at a given number of false echoes; time. Methods share the default chain's equalizers and filter.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from benchmarks.level_methods.cases import Case, bed_cases, clutter_cases, held_out_cases, tank_cases
from benchmarks.level_methods.chart import save_chart
from benchmarks.level_methods.features import BASE, Weights, fitted
from benchmarks.level_methods.measure import Figures, found_at, half_found_db, level_of_one, milliseconds, score_at
from benchmarks.level_methods.methods import methods
from ods.assess.detection.measure import SWEEP_CELLS
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.plots.style import add_style

JUDGED, TRAINED = 0, 7
"""Seeds: nothing that is judged is trained on."""
BODY_DB = (-1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 10.0)
ROUNDS = 30
SHAPES, KINDS = (0.5, 1.0, 2.0, 5.0), ("cells", "patches")
"""Of the K-distributed clutter: shapes, and what of a texture is alike."""
BED = "sea-beds"


def main() -> None:
    """Print the table and draw the chart."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--images", type=int, default=16, help="of each kind of clutter, and as many of tanks")
    parser.add_argument("--out", type=Path, help="the chart")
    add_style(parser)
    options = parser.parse_args()
    figures = measured(options.images)
    _print_table(figures)
    if options.out:
        save_chart(options.out, figures, BED, options.style)


def measured(images: int) -> list[Figures]:
    """Return the figures of all methods."""
    speckle = clutter_cases(2 * images, JUDGED + 1)
    beds = bed_cases(max(2, images // 4), JUDGED)
    clutter = _clutter(images, beds)
    found = {
        BED: (beds, 1.0),
        "K 1 patches": (clutter_cases(images, JUDGED + 3, 1.0, patches=True, body_db=10.0), 1.0),
        "tank": (tank_cases(images, 909), 4.0),
        "held out": (held_out_cases(images // 2, 909), 4.0),
    }
    by_db = {db: clutter_cases(2 * images, JUDGED + 4, body_db=db) for db in BODY_DB}
    figures = []
    for method in methods(_trained(images)):
        one = Figures(method, level_of_one(method, speckle))
        one.clutter = {name: score_at(method, one.at_one, cases).false_per_image for name, cases in clutter.items()}
        one.half_db = half_found_db(method, one.at_one, by_db)
        one.found = {name: found_at(method, cases, wanted) for name, (cases, wanted) in found.items()}
        figures.append(one)
    for one, ms in zip(figures, milliseconds(figures, speckle[0].looks, ROUNDS), strict=True):
        one.ms = ms
    return figures


def _print_table(figures: Sequence[Figures]) -> None:
    """Print one line a method."""
    first = figures[0]
    kinds = [f"K {kind}, {', '.join(f'{shape:g}' for shape in SHAPES)}" for kind in KINDS]
    headings = ["method", "ms", "loss, dB", *kinds, BED, *(f"Pd {name}" for name in first.found)]
    print("|", " | ".join(headings), "|\n" + "|---" * len(headings) + "|")
    for one in figures:
        texts = [one.method.name + (" (numpy)" if one.method.plain else ""), f"{one.ms:.2f}"]
        texts += [f"{one.half_db - first.half_db:+.2f}"]
        texts += [" ".join(f"{one.clutter[_clutter_name(shape, kind)]:.2f}" for shape in SHAPES) for kind in KINDS]
        texts += [f"{one.clutter[BED]:.2f}", *(_share(*found) for found in one.found.values())]
        print("|", " | ".join(texts), "|")


def _clutter_name(shape: float, kind: str) -> str:
    return f"K {shape:g} {kind}"


def _share(share: float, low: float, high: float) -> str:
    return f"{share:.2f} ({low:.2f}-{high:.2f})" if share == share else ""


def _clutter(images: int, beds: list[Case]) -> dict[str, list[Case]]:
    clutter = {
        _clutter_name(shape, kind): clutter_cases(images, JUDGED + 2, shape, patches=kind == "patches")
        for shape in SHAPES
        for kind in KINDS
    }
    return clutter | {BED: beds}


def _trained(images: int) -> Weights:
    """Return the weights of region features, from images of other seeds."""
    *before, detector = PipelineSettings().at_spacing(0.05).stage
    settings = PipelineSettings(stage=(*before, {**detector, "follow": 0.0, "high": BASE}))
    examples = []
    for case in bed_cases(max(2, images // 4), TRAINED) + tank_cases(images, TRAINED):
        ping = case.looks[-1].ping
        examples.append((ping, Chain(settings, learnt_cells=SWEEP_CELLS).process(ping).detections, case.targets))
    return fitted(examples)


if __name__ == "__main__":
    main()
