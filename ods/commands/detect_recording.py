"""`ods detect`: the pipeline as on board, on recorded sonar images."""

from argparse import Namespace
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ods.base.command_line.arguments import Choice
from ods.base.errors import OdsError, reason_of
from ods.base.files.out_file import refuse_unwritable
from ods.base.settings_file import load, load_table
from ods.config import OnboardConfig
from ods.offline.recorded import pings_of
from ods.pipeline import offline
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.watch import StageImage
from ods.plots.style import drawn_in, refuse_undrawable
from ods.sonar_link.files.decoder import PLUGINS
from ods.sonar_link.files.fan_image import FanGeometry
from ods.sonar_link.files.settings import RecordingsSettings

MOST_ON_A_SHEET = 48
"""Pings; with more, none is large enough to be read."""


def run(args: Namespace) -> None:
    """Run the pipeline over a recording; without a configuration with its default chain. Raises OdsError."""
    settings = _settings(args.config)
    read = (args.file, args.config, args.fan)
    pictures = args.plot, args.sheet, args.plot_stages
    refuse_unwritable(args.out, *pictures, read=read)
    refuse_undrawable(*pictures)  # which also finds that matplotlib, an extra, is missing
    recording = pings_of(args.file, load(args.fan, FanGeometry) if args.fan else None)
    places = _places(args, len(recording.pings))
    stages: list[StageImage] = []
    results = []
    for result in offline.detect_pings(
        (recording.pings[place] for place in places),
        settings,
        places=places,
        masks=args.mask,
        watch=stages.append if args.plot_stages else None,
    ):
        results.append(result)
        _tell(result, args)
        if args.plot_stages:
            with drawn_in(args.style):
                _draw_stages(_name(args.plot_stages, result, places), result, stages)
            stages.clear()
    for what, count in sorted(recording.losses.items()):
        if not args.json:
            print(f"{what}: {count}")
    if not results:
        raise OdsError(f"{args.file}: no pings in it")
    if args.out is not None:
        _written(args.out, partial(offline.save_npz, args.out, results))
    if any(pictures):
        with drawn_in(args.style):
            _draw(args, results, places)


def _settings(config: Path | None) -> PipelineSettings:
    if config is None:
        return PipelineSettings()
    PLUGINS.load(load_table(config, "recordings", RecordingsSettings, OnboardConfig).plugins)
    return load_table(config, "pipeline", PipelineSettings, OnboardConfig)


def _places(args: Namespace, count: int) -> Sequence[int]:
    """Return where in the recording the pings stand that were chosen."""
    chosen: Choice | None = args.pings
    try:
        places = range(count) if chosen is None else chosen.of(count)
    except ValueError as error:
        raise OdsError(f"--pings {error}") from error
    if args.sheet and len(places) > MOST_ON_A_SHEET:
        raise OdsError(f"--sheet: {len(places)} pings, and {MOST_ON_A_SHEET} fit: choose some by --pings")
    return places


def _tell(result: offline.PingResult, args: Namespace) -> None:
    if args.json:
        print(offline.json_line(result))
    elif not args.quiet:
        print(_line(result))


def _line(result: offline.PingResult) -> str:
    detections = result.detections.detections
    brightest = sorted(detections, key=lambda item: -item.peak)[:3]
    text = ", ".join(
        f"{d.range_m:.1f} m at {np.degrees(d.bearing_rad):+.1f} deg (r {d.radius_m:.1f} m)" for d in brightest
    )
    return f"ping {result.place}: {len(detections)} detections" + (f"; strongest: {text}" if text else "")


def _written(file: Path, write: Callable[[], object]) -> None:
    """Write a file. Raises OdsError."""
    try:
        write()
    except (OSError, ValueError) as error:
        raise OdsError(f"{file}: {reason_of(error)}") from error


def _name(plot: Path, result: offline.PingResult, places: Sequence[int]) -> Path:
    """Return the name of one ping's picture: `plot` for a single one, else with the ping's place before the suffix."""
    return plot if len(places) == 1 else plot.with_stem(f"{plot.stem}-{result.place}")


def _draw(args: Namespace, results: Sequence[offline.PingResult], places: Sequence[int]) -> None:
    """Draw one picture a ping, or all on one."""
    from rich.progress import track as progress

    from ods.plots.fan import ping_figure
    from ods.plots.sheet import SheetItem, sheet_figure

    if args.plot:
        for result in progress(results, description="drawing", transient=True):
            name = _name(args.plot, result, places)
            _written(name, partial(ping_figure(result.ping, result.detections).savefig, name))
    if args.sheet and results:
        items = [SheetItem(_title(result), result.ping, result.detections) for result in results]
        _written(args.sheet, partial(sheet_figure(items).savefig, args.sheet))


def _draw_stages(file: Path, result: offline.PingResult, stages: Sequence[StageImage]) -> None:
    from ods.commands.stage_picture import stages_figure

    if stages:
        _written(file, partial(stages_figure(_title(result), stages, result.detections).savefig, file))


def _title(result: offline.PingResult) -> str:
    count = len(result.detections.detections)
    return f"ping {result.place}: {count} detection{'' if count == 1 else 's'}"
