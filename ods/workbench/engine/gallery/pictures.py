"""Pictures of the gallery's demos, drawn in a process of its own, as Matplotlib is large."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ods.base.clock import NS
from ods.base.settings_file import load
from ods.offline.picture import draw_run
from ods.plots.fan import ping_figure
from ods.plots.style import DARK, QUIET, SERIES, drawn_in
from ods.sonar_link.files.fan_image import FanGeometry
from ods.sonar_link.files.opening import open_pings
from ods.workbench.engine.background.own_process import GoesOn
from ods.workbench.engine.gallery.demos import SONAR, Demo, DemoResult
from ods.workbench.engine.printing import detections_of
from ods.workbench.engine.scene.rehearsal import Rehearsal, rehearse_file
from ods.workbench.model.state import State

WIDTH_IN = 10.0
"""Of the pictures."""
STILL = (0.0, 0.0, 0.0)


def draw(progress: GoesOn, demo: Demo, base: State, stem: Path) -> DemoResult | None:
    """Draw the pictures of an demo, whose names begin with `stem`; None: given up. Raises OdsError."""
    with drawn_in(DARK):
        if demo.file is not None:
            return _recorded(demo.file, base, stem)
        return _rehearsed(progress, demo, base, stem)


def _recorded(file: Path, base: State, stem: Path) -> DemoResult:
    fan = load(file.with_suffix(".toml"), FanGeometry) if file.suffix.lower() == ".avi" else None
    recording = open_pings(file, fan)
    ping = recording.pings[0]
    found = detections_of(ping, base.tuning)
    picture = stem.with_suffix(".png")
    ping_figure(ping, found, f"{file.name}, first ping").savefig(picture)
    facts = f"{len(recording.pings)} pings of {ping.beams} x {ping.samples}; in the first"
    return DemoResult(f"{facts} {len(found.detections)} detections.", [picture.name])


def _rehearsed(progress: GoesOn, demo: Demo, base: State, stem: Path) -> DemoResult | None:
    assert demo.scene is not None
    result = rehearse_file(progress, demo.scene, SONAR, base.tuning.mission())
    if result is None:
        return None
    run, velocities = stem.with_suffix(".png"), stem.with_name(f"{stem.name}-velocities.png")
    draw_run(result.record, run, width_in=WIDTH_IN)
    pictures = [run.name]
    if any(item.velocity_ned != STILL for truth in result.truths for item in truth.objects):
        _velocities(result).savefig(velocities, dpi=110)
        pictures.append(velocities.name)
    tracked = ", ".join(f"{item.name} {item.tracked_share:.0%}" for item in result.objects)
    facts = (
        f"{len(result.record.lists)} pings; tracked: {tracked or 'nothing'}; {result.false_tracks} false tracks; "
        f"position rms {result.position_rms_m:.2f} m."
    )
    return DemoResult(facts, pictures)


def _velocities(result: Rehearsal) -> Figure:
    """Return velocities north and east of the tracks over time, and the true ones."""
    figure = Figure(figsize=(WIDTH_IN, 0.34 * WIDTH_IN), layout="constrained")
    true: dict[str, list[tuple[float, ...]]] = {}
    for truth in result.truths:
        for item in truth.objects:
            true.setdefault(item.name, []).append((truth.t_ns / NS, *item.velocity_ned[:2]))
    tracks: dict[int, list[tuple[float, ...]]] = {}
    for _, latest in result.record.lists:
        for obstacle in latest.obstacles:
            tracks.setdefault(obstacle.id, []).append((latest.t_ns / NS, *obstacle.velocity_ned[:2]))
    for column, (axes, name) in enumerate(zip(figure.subplots(1, 2), ("north", "east"), strict=True), 1):
        for place, (number, rows) in enumerate(tracks.items()):
            values = np.array(rows)
            axes.plot(
                values[:, 0], values[:, column], color=SERIES[place % len(SERIES)], lw=1.2, label=f"track {number}"
            )
        for label, rows in true.items():
            values = np.array(rows)
            axes.plot(values[:, 0], values[:, column], color=QUIET, ls="--", lw=1.0, label=f"{label}, true")
        axes.set_xlabel("time, s")
        axes.set_ylabel(f"velocity {name}, m/s")
        axes.set_ylim(-1.5, 1.5)
        axes.grid()
        if len(tracks) + len(true) <= 10:
            axes.legend(fontsize="small")
    return figure
