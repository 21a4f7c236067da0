"""Pictures and movies for paper and screen: of what a state shows, with the hash of its configuration."""

import hashlib
import json
import threading
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.mounting import Mounting
from ods.messages import Detections, Ping
from ods.offline.mission import Mission
from ods.offline.source import Source
from ods.pipeline.offline import detect_pings
from ods.workbench.engine.data import Data
from ods.workbench.engine.folders import writable, write_whole
from ods.workbench.model.short_tables import short_tables
from ods.workbench.model.state import Tuning

PICTURES, MOVIES = (".png", ".svg", ".pdf"), (".webp", ".gif")
ONE_AT_A_TIME = threading.Lock()
"""Matplotlib's style is the process's."""


def config_hash(tuning: Tuning) -> str:
    """Return twelve hexadecimal digits that another configuration of pipeline and tracker has not."""
    text = json.dumps(short_tables(tuning.mission()), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def detections_of(ping: Ping, tuning: Tuning) -> Detections:
    """Return what a chain finds in one ping alone. Raises StageError; OdsError for a ping that makes no sense."""
    for result in detect_pings([ping], tuning.pipeline()):
        return result.detections
    raise OdsError(f"ping {ping.ping_number}: makes no sense")


def print_ping(ping: Ping, tuning: Tuning, file: Path, folders: Sequence[Path], *, name: str, style: str) -> Path:
    """Draw a ping with its detections into a file; its ending tells the format. Raises OdsError, StageError."""
    place = place_to_write(file, PICTURES, folders)
    found = detections_of(ping, tuning)
    from ods.plots.fan import ping_figure
    from ods.plots.style import drawn_in

    with ONE_AT_A_TIME, drawn_in(style):
        figure = ping_figure(ping, found)
        count = len(found.detections)
        caption = f"{name}, ping {ping.ping_number}: {count} detections; configuration {config_hash(tuning)}"
        figure.text(0.01, 0.005, caption, fontsize=8, ha="left", va="bottom")
        drawn = BytesIO()
        figure.savefig(drawn, format=place.suffix[1:], metadata={"Title": caption})
    write_whole(place, drawn.getvalue())
    return place


def record_movie(
    data: Data, tuning: Tuning, file: Path, folders: Sequence[Path], *, tell: Callable[[float], bool], style: str
) -> Path:
    """Write a run over all pings as a movie: images beside the plan. Raises OdsError, StageError.

    tell: is told the share that is done; when it returns false, what has been drawn until then is written.
    """
    place = place_to_write(file, MOVIES, folders)
    from ods.plots.style import drawn_in
    from ods.track.outputs import Outputs, Wanted

    source = Source(data.pings, data.poses_in_time, data.truths, data.losses, data.frame)
    settings, count = tuning.mission(), len(source.pings)
    with ONE_AT_A_TIME, drawn_in(style):
        wanted = Wanted(out=None, json=False, geojson=None, plot=None, movie=place)
        outputs = Outputs(wanted, source, count, Mounting(settings.mounting))
        for done, step in enumerate(Mission(settings).steps(source.pings, source.poses), 1):
            outputs.take(step)
            if not tell(done / count):
                break
        outputs.write()
    return place


def place_to_write(file: Path, endings: tuple[str, ...], folders: Sequence[Path]) -> Path:
    """Return where a file is written. Raises OdsError for another ending, or a place outside the folders."""
    if file.suffix.lower() not in endings:
        raise OdsError(f"{file}: the ending must be one of {', '.join(endings)}")
    place = writable(file, folders)
    if not place.parent.is_dir():
        raise OdsError(f"{file}: no such folder")
    return place
