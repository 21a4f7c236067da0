"""`ods track`: pipeline and tracker as on board, on recorded or simulated pings; the tracker alone on scenarios."""

from argparse import Namespace
from collections.abc import Iterator
from contextlib import ExitStack
from typing import NamedTuple

from rich.console import Console
from rich.progress import track as progress

from ods.base.command_line.arguments import Choice
from ods.base.errors import OdsError
from ods.base.files.out_file import refuse_unwritable
from ods.base.frames.mounting import AT_ORIGIN, Mounting, mounting_in
from ods.base.geodesy import LocalFrame
from ods.base.settings_file import load, load_table
from ods.config import OnboardConfig, part_of
from ods.export.place import place_of
from ods.messages import Ping
from ods.offline.mission import Mission, MissionSettings
from ods.offline.recorded import is_recording
from ods.offline.source import Source, open_source
from ods.plots.style import drawn_in
from ods.recording.mcap.reader import open_recording
from ods.sonar_link.files.decoder import PLUGINS
from ods.sonar_link.files.fan_image import FanGeometry
from ods.track.outputs import Outputs, Wanted
from ods.tracker import scenario
from ods.tracker.settings import TrackerSettings


class _Run(NamedTuple):
    """What is run, and by what settings."""

    source: Source
    settings: MissionSettings
    places: list[int]


def run(args: Namespace) -> None:
    """Track a file or a scene; without a configuration with default settings. Raises OdsError."""
    if scenario.is_scenario(args.file):
        _track_scenario(args)
        return
    wanted = Wanted(args.out, args.json, args.geojson, args.plot, args.movie)
    wanted.check(args.file, args.config, args.fan)
    run_ = _prepared(args)
    with ExitStack() as stack:
        if args.plot or args.movie:
            stack.enter_context(drawn_in(args.style))
        outputs = Outputs(wanted, run_.source, len(run_.places), Mounting(run_.settings.mounting))
        mission = Mission(run_.settings)
        for step in mission.steps(_shown(run_, args.file.name), run_.source.poses):
            outputs.take(step)
        outputs.write()
    outputs.report(mission.counters)


def _track_scenario(args: Namespace) -> None:
    asked = [name for name in ("json", "geojson", "plot", "movie", "pings") if getattr(args, name)]
    if asked:
        raise OdsError(f"--{asked[0]}: {args.file} is a scenario of detections, for which only --out is written")
    if args.out is None:
        raise OdsError("--out: name the file for the scenario's tracks")
    refuse_unwritable(args.out, read=(args.file, args.config))
    settings = load_table(args.config, "tracker", TrackerSettings, OnboardConfig) if args.config else TrackerSettings()
    mounting = Mounting(mounting_in(args.config)) if args.config else AT_ORIGIN
    print(scenario.track_file(args.file, args.out, settings, mounting))


def _prepared(args: Namespace) -> _Run:
    settings, site = MissionSettings(), None
    if args.geojson and not args.config and is_recording(args.file):
        site = place_of(open_recording(args.file).attachments, None).frame
    if args.config:
        config = load(args.config, OnboardConfig)
        PLUGINS.load(config.recordings.plugins)
        settings = part_of(config, MissionSettings)
        site = LocalFrame(config.site.latitude_deg, config.site.longitude_deg)
    fan = load(args.fan, FanGeometry) if args.fan else None
    source = open_source(args.file, sonar=args.sonar, fan=fan, site=site)
    count = len(source.pings)
    chosen: Choice | None = args.pings
    try:
        places = list(range(count)) if chosen is None else chosen.of(count)
    except ValueError as error:
        raise OdsError(f"--pings {error}") from error
    return _Run(source, settings, places)


def _shown(run_: _Run, name: str) -> Iterator[Ping]:
    """Yield the pings, with a bar that shows how far it is."""
    console = Console(stderr=True)
    for place in progress(run_.places, f"{name}:", console=console, disable=not console.is_terminal):
        yield run_.source.pings[place]
