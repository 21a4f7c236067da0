"""Pictures and movies for paper and screen: of what a state shows, with the hash of its configuration."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.frames.mounting import Mounting
from ods.messages import Detections, Ping
from ods.offline.mission import Mission
from ods.offline.source import Source
from ods.pipeline.offline import detect_pings
from ods.workbench.engine.background.own_process import GoesOn
from ods.workbench.engine.data import Data, open_data
from ods.workbench.engine.echogram.layers import Layers
from ods.workbench.engine.echogram.levels import Echogram
from ods.workbench.engine.files.folders import write_whole
from ods.workbench.engine.files.prints import MOVIES, PICTURES, config_hash, place_to_write
from ods.workbench.model.state import State, Tuning


def detections_of(ping: Ping, tuning: Tuning) -> Detections:
    """Return what a chain finds in one ping alone. Raises StageError; OdsError for an invalid ping."""
    for result in detect_pings([ping], tuning.pipeline()):
        return result.detections
    raise OdsError(f"ping {ping.ping_number}: its contents are invalid")


def print_ping(ping: Ping, tuning: Tuning, file: Path, folders: Sequence[Path], *, name: str, style: str) -> Path:
    """Draw a ping with its detections into a file; its ending chooses the format. Raises OdsError, StageError."""
    place = place_to_write(file, PICTURES, folders)
    found = detections_of(ping, tuning)
    from ods.plots.fan import ping_figure
    from ods.plots.style import drawn_in

    with drawn_in(style):
        figure = ping_figure(ping, found)
        count = len(found.detections)
        caption = f"{name}, ping {ping.ping_number}: {count} detections; configuration {config_hash(tuning)}"
        figure.text(0.01, 0.005, caption, fontsize=8, ha="left", va="bottom")
        drawn = BytesIO()
        figure.savefig(drawn, format=place.suffix[1:], metadata={"Title": caption})
    write_whole(place, drawn.getvalue())
    return place


def record_movie(
    data: Data, tuning: Tuning, file: Path, folders: Sequence[Path], *, progress: GoesOn, style: str
) -> Path:
    """Write a run over all pings as a movie: images beside the plan. Raises OdsError, StageError.

    progress: gets the share that is done; when it returns false, what has been drawn until then is written.
    """
    place = place_to_write(file, MOVIES, folders)
    from ods.plots.style import drawn_in
    from ods.track.outputs import Outputs, Wanted

    source = Source(data.pings, data.poses_in_time, data.truths, data.losses, data.frame)
    settings, count = tuning.mission(), len(source.pings)
    with drawn_in(style):
        wanted = Wanted(out=None, json=False, geojson=None, plot=None, movie=place)
        outputs = Outputs(wanted, source, count, Mounting(settings.mounting))
        for done, step in enumerate(Mission(settings).steps(source.pings, source.poses), 1):
            outputs.take(step)
            if not progress(done / count):
                break
        outputs.write()
    return place


def ping_of(_: GoesOn, state: State, read: Sequence[Path], file: Path, *, style: str) -> Path:
    """Print the ping that a state shows; read: folders of its data. `file` may lie anywhere. Raises OdsError."""
    data = open_data(state.data, state.scene, read)
    ping = data.pings[min(state.ping, len(data.pings) - 1)]
    return print_ping(ping, state.tuning, file, [file.parent], name=called(state), style=style)


def movie_of(progress: GoesOn, state: State, read: Sequence[Path], file: Path, *, style: str) -> Path:
    """Record the movie of a state's mission; read: folders of its data. `file` may lie anywhere. Raises OdsError."""
    data = open_data(state.data, state.scene, read)
    return record_movie(data, state.tuning, file, [file.parent], progress=progress, style=style)


def echogram_of(_: GoesOn, echogram: Echogram, layers: Layers, state: State, file: Path, *, style: str) -> Path:
    """Print an echogram. `file` may lie anywhere. Raises OdsError."""
    from ods.workbench.engine.echogram.paper import print_echogram  # Matplotlib: not in the page's process

    return print_echogram(echogram, layers, state, file, [file.parent], name=called(state), style=style)


def called(state: State) -> str:
    """Return what a print calls the data."""
    return Path(state.data.path).name or state.data.kind
