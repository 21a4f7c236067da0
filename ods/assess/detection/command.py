"""`ods assess detect`: accuracy against time of every filter x detector x attention, on simulated and real images."""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track as progress
from rich.table import Table

from ods.assess.detection.chains import ATTENTION, DEFAULT, Setting, all_settings
from ods.assess.detection.measure import Accuracy, accuracy_of, filter_figures, milliseconds, score_of, stability
from ods.assess.detection.metrics import Score, pareto_front
from ods.assess.images.held_out import held_out_images
from ods.assess.images.labelled import LabelledImage
from ods.assess.images.labels import read_labels
from ods.assess.images.sea import sea_images
from ods.assess.images.tank import tank_images
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.sonar_link.files.opening import open_pings

REAL = {
    "tests/data/aris/sample.aris": "tests/data/labels/aris_sample.txt",
    "tests/data/oculus/three_pings_8bit.raw": "tests/data/labels/oculus_three_pings.txt",
}
"""Real frames and their labels; those were drawn by eye, of things that nobody knows the truth of."""


@dataclass(frozen=True)
class Effort:
    """How much is measured."""

    sea: int
    """Simulated images of the obstacle-avoidance sonar."""
    tank: int
    """Look-alikes of tank images."""
    checked: int
    """Look-alikes of each model that the default chain is checked on, at its own levels."""
    filtered: int
    """Images that filters are judged by."""
    rounds: int
    """Times that each chain is timed."""
    settings: int
    """Settings at most."""


FULL = Effort(sea=32, tank=20, checked=200, filtered=8, rounds=12, settings=1000)
QUICK = Effort(sea=4, tank=3, checked=3, filtered=1, rounds=3, settings=4)
SEED = 4
CHECK_SEED = 909
"""Of the look-alikes that nothing was chosen on."""
SEA_FALSE_ALARMS = 1.0
"""An image, at which settings are compared."""
TANK_FALSE_ALARMS = 4.0
"""Likewise: the walls of a tank are echoes that no label names."""


@dataclass(frozen=True)
class Row:
    """What is known of one setting."""

    name: str
    ms: float
    """Median for one simulated image, everything included."""
    sea: Accuracy
    tank: Accuracy
    noise_db: float
    """Noise suppression of its filters."""
    edges: float
    """Their edge preservation."""


def add_arguments(parser: ArgumentParser) -> None:
    """Chart and effort."""
    parser.add_argument("--out", type=Path, metavar="CHART.png", help="draw the chart")
    parser.add_argument("--quick", action="store_true", help="a few images and settings, to see that it works")


def run(args: Namespace) -> None:
    """Measure, print and draw. Raises OdsError."""
    assess(args.out, quick=args.quick)


def assess(out: Path | None, *, quick: bool) -> None:
    """Measure all settings, print the table, draw the chart. Raises OdsError."""
    effort = QUICK if quick else FULL
    rows = measure(effort)
    front = pareto_front([row.ms for row in rows], [row.sea.detection_probability for row in rows])
    console = Console(width=150)
    console.print(table_of(rows, front))
    for line in (*attention_costs(rows), *checks(effort.checked)):
        console.print(line)
    if out is not None:
        from ods.assess.detection.chart import save_chart

        save_chart(out, rows, front)
        console.print(f"drawn: {out}")


def attention_costs(rows: Sequence[Row]) -> Iterator[str]:
    """Yield what each attention costs and saves: means over all settings that were measured with it and without."""
    by_name = {row.name: row for row in rows}
    for attention in filter(None, ATTENTION):
        ending = f", {attention}"
        pairs = [(whole, by_name[name + ending]) for name, whole in by_name.items() if name + ending in by_name]
        if pairs:
            sea = np.mean([part.sea.detection_probability - whole.sea.detection_probability for whole, part in pairs])
            tank = np.mean(
                [part.tank.detection_probability - whole.tank.detection_probability for whole, part in pairs]
            )
            ms = np.median([part.ms / whole.ms for whole, part in pairs])
            yield f"{attention}: Pd sea {sea:+.3f}, tank {tank:+.3f}, {ms:.2f} times the time ({len(pairs)} settings)"


def checks(count: int) -> Iterator[str]:
    """Yield what the default chain finds at its own levels: on look-alikes of two models, and on real frames."""
    looks = {"tank look-alikes": tank_images(count, CHECK_SEED), "held-out": held_out_images(count, CHECK_SEED)}
    for name, images in looks.items():
        yield f"default chain on {len(images)} {name}: {_figures(score_of(PipelineSettings(), images))}"
    for file, labels in REAL.items():
        if not Path(file).exists():
            continue
        pings = open_pings(Path(file)).pings
        clusters, again = steadiness(pings)
        score = score_of(PipelineSettings(), read_labels(Path(labels), pings))
        yield f"{file}, labelled by eye: {_figures(score)}"
        yield f"{file}: {clusters:.1f} clusters a frame, {again:.0%} of them again in the next"


def _figures(score: Score) -> str:
    share = f"{score.found} of {score.targets} ({score.detection_probability:.1%})"
    return f"found {share}, {score.false_per_image:.1f} unlabelled clusters a frame"


def measure(effort: Effort) -> list[Row]:
    """Return one row for each setting, in the order of the table of settings."""
    settings = all_settings()[: effort.settings]
    sea, tank = sea_images(effort.sea, SEED), tank_images(effort.tank, SEED)
    spent = milliseconds([_in_service(each) for each in settings], sea[0].ping, effort.rounds)
    figures = _filter_figures(settings, sea[: effort.filtered])
    return [
        Row(
            each.name,
            ms,
            accuracy_of(each, sea, SEA_FALSE_ALARMS),
            accuracy_of(each, tank, TANK_FALSE_ALARMS),
            *figures[repr(each.filters)],
        )
        for each, ms in zip(progress(settings, description="assessing", transient=True), spent, strict=True)
    ]


def _in_service(setting: Setting) -> PipelineSettings:
    """Return the step of the sweep that time is taken at: the default's own levels, the middle of the others."""
    return PipelineSettings() if setting.name == DEFAULT else setting.settings[len(setting.settings) // 2]


def _filter_figures(settings: Sequence[Setting], images: Sequence[LabelledImage]) -> dict[str, tuple[float, float]]:
    """Return noise suppression and edge preservation by the filters' text: several settings share theirs."""
    figures: dict[str, tuple[float, float]] = {}
    for setting in settings:
        key = repr(setting.filters)
        if key not in figures:
            figures[key] = filter_figures(setting.filters, images)
    return figures


def steadiness(pings: Sequence[Ping]) -> tuple[float, float]:
    """Return clusters a frame of the default chain, and the share of them that the next frame shows again."""
    chain = Chain(PipelineSettings())
    return stability([chain.process(ping) for ping in pings])


def table_of(rows: Sequence[Row], front: Sequence[int]) -> Table:
    """Return the table of all settings, numbered as in the chart, those on the front marked."""
    table = Table(title="at 1 false alarm an image (tank: 4); * on the Pareto front of the simulated sea")
    for heading in ("setting", "ms", "Pd sea", "position, m", "radius", "Pd tank", "noise, dB", "edges"):
        table.add_column(heading, justify="left" if heading == "setting" else "right")
    for index, row in enumerate(rows):
        table.add_row(
            f"{'*' if index in front else ' '} {index:2d} {row.name}",
            f"{row.ms:.3f}",
            f"{row.sea.detection_probability:.3f}",
            f"{row.sea.position_error_m:.2f}",
            f"{row.sea.radius_error:.0%}",
            f"{row.tank.detection_probability:.3f}",
            f"{row.noise_db:.1f}",
            f"{row.edges:.2f}",
        )
    return table
