"""`ods detect` and `ods track`: the same code as on board, on recorded files."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.progress import track as progress

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.pipeline import offline
from ods.pipeline.settings import PipelineSettings
from ods.plots import fan
from ods.sonar_link.files.fan_image import FanGeometry
from ods.sonar_link.files.opening import open_pings
from ods.tracker import scenario
from ods.tracker.settings import TrackerSettings


class OfflineError(OdsError):
    """A file cannot be written; the text is one line."""


def detect(
    file: Path,
    config: Path | None,
    *,
    fan: Path | None = None,
    out: Path | None = None,
    mask: bool = False,
    as_json: bool = False,
    plot: Path | None = None,
) -> None:
    """Run the pipeline over a recording; without `config` with its default chain. Raises OdsError.

    fan: TOML file with the geometry of the images of an .avi clip.
    """
    settings = load(config, OnboardConfig).pipeline if config else PipelineSettings()
    if mask and out is None:
        raise OfflineError("--mask: goes into the file that --out names")
    recording = open_pings(file, load(fan, FanGeometry) if fan else None)
    results = list(offline.detect_pings(recording.pings, settings, masks=mask))
    for result in results:
        print(offline.json_line(result) if as_json else _line(result))
    for what, count in sorted(recording.losses.items()):
        if not as_json:
            print(f"{what}: {count}")
    try:
        if out is not None:
            offline.save_npz(out, results)
        if plot is not None:
            _draw(plot, results)
    except (OSError, ValueError) as error:
        raise OfflineError(f"{out if plot is None else plot}: {error}") from error


def _line(result: offline.PingResult) -> str:
    detections = result.detections.detections
    brightest = sorted(detections, key=lambda item: -item.peak)[:3]
    text = ", ".join(
        f"{d.range_m:.1f} m at {np.degrees(d.bearing_rad):+.1f} deg (r {d.radius_m:.1f} m)" for d in brightest
    )
    return f"ping {result.place}: {len(detections)} detections" + (f"; brightest: {text}" if text else "")


def _draw(plot: Path, results: Sequence[offline.PingResult]) -> None:
    """Draw one picture a ping: PLOT for a single one, PLOT with the ping's index before the suffix for more."""
    for result in progress(results, description="drawing", transient=True):
        name = plot if len(results) == 1 else plot.with_stem(f"{plot.stem}-{result.place}")
        fan.ping_figure(result.ping, result.detections).savefig(name)


def track(file: Path, config: Path | None, out: Path) -> None:
    """Run the tracker over a scenario; without `config` with its default settings. Raises OdsError."""
    settings = load(config, OnboardConfig).tracker if config else TrackerSettings()
    print(scenario.track_file(file, out, settings))
