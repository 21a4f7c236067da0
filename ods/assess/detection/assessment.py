"""`ods assess detect`: accuracy against time of every filter x detector x attention, on simulated and real images."""

from argparse import Namespace
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.console import Console
from rich.progress import track as progress

from ods.assess.detection.chains import DEFAULT, Setting, all_settings
from ods.assess.detection.checks import check_look_alikes, check_recording
from ods.assess.detection.measure import SettingRow, accuracy_of, filter_figures, milliseconds
from ods.assess.detection.metrics import pareto_front
from ods.assess.detection.own import configured, measure_own, own_images, own_table, whole_image_settings
from ods.assess.detection.table import attention_costs, setting_table
from ods.assess.images.labelled import LabelledImage
from ods.assess.images.sea import sea_images
from ods.assess.images.tank import tank_images
from ods.base.settings_file import load_table
from ods.config import OnboardConfig
from ods.pipeline.settings import PipelineSettings
from ods.plots.style import refuse_undrawable
from ods.sim_sonar.by_name import find_sonar
from ods.sonar_link.files.decoder import PLUGINS
from ods.sonar_link.files.settings import RecordingsSettings


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
    without: tuple[str, ...] = ()
    """Words; settings whose names have one of them are left out."""


FULL_EFFORT = Effort(sea=160, tank=60, checked=200, filtered=8, rounds=12, settings=1000)
QUICK_EFFORT = Effort(sea=4, tank=3, checked=3, filtered=1, rounds=3, settings=4)
IMAGES_SEED = 4
SEA_FALSE_ALARMS = 1.0
"""An image, at which settings are compared."""
TANK_FALSE_ALARMS = 4.0
"""Likewise: the walls of a tank are echoes that no label names."""


def run(args: Namespace) -> None:
    """Measure, print and draw. Raises OdsError."""
    refuse_undrawable(args.out)
    settings = None
    effort = replace(QUICK_EFFORT if args.quick else FULL_EFFORT, without=tuple(args.without))
    if args.config:
        PLUGINS.load(load_table(args.config, "recordings", RecordingsSettings, OnboardConfig).plugins)
        settings = load_table(args.config, "pipeline", PipelineSettings, OnboardConfig)
    if args.own:
        images = own_images(
            [(recording, labels) for recording, labels in args.real], args.scene, find_sonar(args.sonar)
        )
        assess_own(images, settings, effort)
        return
    real = [(recording, labels) for recording, labels in args.real]
    rows = assess_detection(effort, real)
    if args.out is not None:
        from ods.assess.detection.chart import save_chart

        save_chart(args.out, rows, args.style)
        print(f"drawn: {args.out}")


def assess_detection(effort: Effort, real: Sequence[tuple[Path, Path]] = ()) -> list[SettingRow]:
    """Measure all settings and print the table. Raises OdsError.

    `real`: recordings, each with the labels of its frames.
    """
    rows = measure(effort)
    front = pareto_front([row.ms for row in rows], [row.sea.detection_probability for row in rows])
    console = Console(width=150)
    console.print(setting_table(rows, front))
    for line in (*attention_costs(rows), *_checks(effort.checked, real)):
        console.print(line)
    return rows


def assess_own(images: Sequence[LabelledImage], configured_chain: PipelineSettings | None, effort: Effort) -> None:
    """Judge settings on the user's images, the chain of his configuration among them. Raises OdsError."""
    settings = _measured(whole_image_settings(), effort)
    chosen = [_in_service(each) for each in settings]
    if configured_chain is not None:
        settings, chosen = [configured(configured_chain), *settings], [configured_chain, *chosen]
    Console(width=150).print(own_table(measure_own(settings, chosen, images, effort.rounds), images))


def _checks(count: int, real: Sequence[tuple[Path, Path]]) -> Iterator[str]:
    yield from check_look_alikes(count)
    for recording, labels in real:
        yield from check_recording(recording, labels)
    if not real:
        yield "real frames are omitted: add some with --real RECORDING LABELS"


def measure(effort: Effort) -> list[SettingRow]:
    """Return one row for each setting, in the order of the table of settings."""
    settings = _measured(all_settings(), effort)
    sea, tank = sea_images(effort.sea, IMAGES_SEED), tank_images(effort.tank, IMAGES_SEED)
    spent = milliseconds([_in_service(each) for each in settings], sea[0].ping, effort.rounds)
    figures = _filter_figures(settings, sea[: effort.filtered])
    return [
        SettingRow(
            each.name,
            ms,
            accuracy_of(each, sea, SEA_FALSE_ALARMS),
            accuracy_of(each, tank, TANK_FALSE_ALARMS),
            *figures[repr(each.filters)],
        )
        for each, ms in zip(progress(settings, description="assessing", transient=True), spent, strict=True)
    ]


def _measured(settings: Sequence[Setting], effort: Effort) -> list[Setting]:
    return [each for each in settings if not any(word in each.name for word in effort.without)][: effort.settings]


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
