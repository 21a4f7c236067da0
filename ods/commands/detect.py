"""`ods detect`: the pipeline as on board, on recorded sonar images."""

import importlib
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ods.base.errors import OdsError
from ods.base.settings_file import load, load_table
from ods.config import OnboardConfig
from ods.pipeline import offline
from ods.pipeline.settings import PipelineSettings
from ods.sonar_link.files.fan_image import FanGeometry
from ods.sonar_link.files.opening import open_pings


class DetectError(OdsError):
    """A file cannot be written; the text is one line."""


def add_arguments(parser: ArgumentParser) -> None:
    """Recording, and what is made of it."""
    parser.add_argument("file", type=Path, metavar="FILE", help=".npz pings, .s7k, .aris, Oculus .raw, .avi")
    parser.add_argument("--fan", type=Path, metavar="FAN.toml", help="geometry of the fan images of an .avi clip")
    parser.add_argument("--out", type=Path, metavar="DET.npz", help="write the detections as .npz")
    parser.add_argument("--mask", action="store_true", help="with --out: label images too")
    parser.add_argument("--json", action="store_true", help="print one JSON line a ping")
    parser.add_argument("--plot", type=Path, metavar="PICTURE.png", help="draw the images with their detections")


def run(args: Namespace) -> None:
    """Run the pipeline over a recording; without a configuration with its default chain. Raises OdsError."""
    settings = PipelineSettings()
    if args.config:
        settings = load_table(args.config, "pipeline", PipelineSettings, OnboardConfig)
    if args.mask and args.out is None:
        raise DetectError("--mask: goes into the file that --out names")
    if args.plot is not None:
        importlib.import_module("matplotlib")  # an extra: that it is missing is said before the work
    recording = open_pings(args.file, load(args.fan, FanGeometry) if args.fan else None)
    results = list(offline.detect_pings(recording.pings, settings, masks=args.mask))
    for result in results:
        print(offline.json_line(result) if args.json else _line(result))
    for what, count in sorted(recording.losses.items()):
        if not args.json:
            print(f"{what}: {count}")
    try:
        if args.out is not None:
            offline.save_npz(args.out, results)
        if args.plot is not None:
            _draw(args.plot, results)
    except (OSError, ValueError) as error:
        raise DetectError(f"{args.out if args.plot is None else args.plot}: {error}") from error


def _line(result: offline.PingResult) -> str:
    detections = result.detections.detections
    brightest = sorted(detections, key=lambda item: -item.peak)[:3]
    text = ", ".join(
        f"{d.range_m:.1f} m at {np.degrees(d.bearing_rad):+.1f} deg (r {d.radius_m:.1f} m)" for d in brightest
    )
    return f"ping {result.place}: {len(detections)} detections" + (f"; brightest: {text}" if text else "")


def _draw(plot: Path, results: Sequence[offline.PingResult]) -> None:
    """Draw one picture a ping: PLOT for a single one, PLOT with the ping's index before the suffix for more."""
    from rich.progress import track as progress

    from ods.plots.fan import ping_figure

    for result in progress(results, description="drawing", transient=True):
        name = plot if len(results) == 1 else plot.with_stem(f"{plot.stem}-{result.place}")
        ping_figure(result.ping, result.detections).savefig(name)
