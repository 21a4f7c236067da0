"""What is shown of the gallery's exhibits: pictures and figures, made once and kept in the user's cache folder."""

import os
import tempfile
import threading
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np
from matplotlib.figure import Figure

from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.in_file import content_of
from ods.base.ownership import is_safe
from ods.base.settings_file import load
from ods.offline.picture import draw_run
from ods.plots.fan import ping_figure
from ods.plots.style import DARK, QUIET, SERIES, drawn_in
from ods.sim_sonar.by_name import find_sonar
from ods.sonar_link.files.fan_image import FanGeometry
from ods.sonar_link.files.opening import open_pings
from ods.workbench.engine.gallery import SONAR, Exhibit
from ods.workbench.engine.printing import detections_of
from ods.workbench.engine.rehearsal import Rehearsal, rehearse
from ods.workbench.engine.scene_view import built
from ods.workbench.model.state import State

WIDTH_IN = 10.0
"""Of the pictures."""
STILL = (0.0, 0.0, 0.0)
_making = threading.Lock()
"""One at a time, whoever asks."""


class Told(msgspec.Struct):
    """What stands beside the pictures in the cache."""

    facts: str
    pictures: list[str]


class Result(NamedTuple):
    """What there is to see."""

    facts: str
    """What came of it, one line."""
    pictures: list[Path]


@cache
def gallery_folder() -> Path:
    """Return where results are kept: $ODS_CACHE_DIR or the user's cache folder, else a folder for this process only."""
    home = os.environ.get("HOME", "")
    own = (os.environ.get(name, "") for name in ("ODS_CACHE_DIR", "XDG_CACHE_HOME"))
    for root in filter(None, (*own, f"{home}/.cache" if home else "")):
        folder = Path(root, "ods", "gallery")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK) and is_safe(folder):
            return folder
    return Path(tempfile.mkdtemp(prefix="ods-gallery-"))


def kept(exhibit: Exhibit, base: State, folder: Path) -> Result | None:
    """Return a result that is there already; None: it has to be made. At once."""
    try:
        told = msgspec.json.decode(content_of(folder / f"{_stem(exhibit, base)}.json"), type=Told)
    except (OSError, msgspec.MsgspecError):
        return None
    pictures = [folder / Path(name).name for name in told.pictures]
    return Result(told.facts, pictures) if all(file.is_file() for file in pictures) else None


def made(
    exhibit: Exhibit, base: State, folder: Path, tell: Callable[[float], None],
    ends: Callable[[], bool] = lambda: False,
) -> Result | None:  # fmt: skip
    """Return a result, made unless it is there; None: `ends` told to give up. Raises OdsError.

    tell: gets the share that is done.
    """
    with _making:
        if (known := kept(exhibit, base, folder)) is not None or ends():
            return known
        stem = _stem(exhibit, base)
        try:
            for old in folder.glob(f"{exhibit.key}-*"):
                old.unlink(missing_ok=True)
            with drawn_in(DARK):
                if exhibit.file is not None:
                    told: Told | None = _recorded(exhibit.file, base, folder / stem)
                else:
                    told = _rehearsed(exhibit, base, folder / stem, _Watch(tell, ends))
            if told is None:
                return None
            (folder / f"{stem}.json").write_bytes(msgspec.json.encode(told))
        except OSError as error:
            raise OdsError(f"{folder}: {error.strerror or error}") from error
        return kept(exhibit, base, folder)


def _stem(exhibit: Exhibit, base: State) -> str:
    return f"{exhibit.key}-{exhibit.digest(base)}"


class _Watch(NamedTuple):
    tell: Callable[[float], None]
    ends: Callable[[], bool]


def _recorded(file: Path, base: State, stem: Path) -> Told:
    fan = load(file.with_suffix(".toml"), FanGeometry) if file.suffix.lower() == ".avi" else None
    recording = open_pings(file, fan)
    ping = recording.pings[0]
    found = detections_of(ping, base.tuning)
    picture = stem.with_suffix(".png")
    ping_figure(ping, found, f"{file.name}, first ping").savefig(picture)
    facts = f"{len(recording.pings)} pings of {ping.beams} x {ping.samples}; in the first"
    return Told(f"{facts} {len(found.detections)} detections.", [picture.name])


def _rehearsed(exhibit: Exhibit, base: State, stem: Path, watch: _Watch) -> Told | None:
    assert exhibit.scene is not None
    result = rehearse(built(exhibit.scene), find_sonar(SONAR), base.tuning.mission(), *watch)
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
    return Told(facts, pictures)


def _velocities(result: Rehearsal) -> Figure:
    """Return velocities north and east of the tracks over time, and the true ones."""
    figure = Figure(figsize=(WIDTH_IN, 0.34 * WIDTH_IN), layout="constrained")
    true: dict[str, list[tuple[float, ...]]] = {}
    for truth in result.truths:
        for item in truth.objects:
            true.setdefault(item.name, []).append((truth.t_ns / NS, *item.velocity_ned[:2]))
    tracks: dict[int, list[tuple[float, ...]]] = {}
    for _, told in result.record.lists:
        for obstacle in told.obstacles:
            tracks.setdefault(obstacle.id, []).append((told.t_ns / NS, *obstacle.velocity_ned[:2]))
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
