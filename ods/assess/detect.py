"""`ods assess detect`: accuracy against time of every filter x detector x attention, on simulated and real images."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import track as progress
from rich.table import Table

from ods.assess.chains import DEFAULT, Setting, all_settings
from ods.assess.labelled import LabelledImage
from ods.assess.measure import Accuracy, accuracy_of, filter_figures, milliseconds, score_of, stability
from ods.assess.metrics import pareto_front
from ods.assess.sea import sea_images
from ods.assess.tank import tank_images
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.sonar_link.files import open_pings

REAL = ("tests/data/aris/sample.aris", "tests/data/oculus/three_pings_8bit.raw")
"""Real frames without labels: how steady the detections are is all that can be said."""


@dataclass(frozen=True)
class Effort:
    """How much is measured."""

    sea: int
    """Simulated images of the obstacle-avoidance sonar."""
    tank: int
    """Look-alikes of tank images."""
    filtered: int
    """Images that filters are judged by."""
    rounds: int
    """Times that each chain is timed."""
    settings: int
    """Settings at most."""


FULL = Effort(sea=80, tank=45, filtered=20, rounds=60, settings=1000)
QUICK = Effort(sea=4, tank=3, filtered=1, rounds=3, settings=4)
SEED = 4
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


def assess(out: Path | None, *, quick: bool) -> None:
    """Measure all settings, print the table, draw the chart. Raises OdsError."""
    rows = measure(QUICK if quick else FULL)
    front = pareto_front([row.ms for row in rows], [row.sea.detection_probability for row in rows])
    console = Console(width=150)
    console.print(table_of(rows, front))
    tanks = tank_images(QUICK.tank if quick else FULL.tank, SEED + 1)
    default = score_of(PipelineSettings(), tanks)
    console.print(
        f"default chain at its own levels on {len(tanks)} tank look-alikes: found "
        f"{default.detection_probability:.1%}, {default.false_per_image:.1f} unlabelled clusters a frame"
    )
    for file in filter(Path.exists, map(Path, REAL)):
        clusters, again = steadiness(open_pings(file).pings)
        console.print(f"{file}: {clusters:.1f} clusters a frame, {again:.0%} of them again in the next")
    if out is not None:
        from ods.assess.chart import save_chart

        save_chart(out, rows, front)
        console.print(f"drawn: {out}")


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
