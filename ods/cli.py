"""The `ods` command: argparse, thin. Every error is one line and exit code 2, a broken limit is exit code 1."""

import argparse
import importlib
import logging
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

from ods import __version__
from ods.base.errors import OdsError
from ods.runtime.processes import PROCESSES, on_board

ONBOARD_CONFIG = Path("config/onboard.toml")
BENCH_CONFIG = Path("config/bench.toml")
LEVELS = ("debug", "info", "warning", "error")


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the `ods` command; return its exit code: 0 good, 1 a limit was broken, 2 an error that one line explains."""
    args = _parser().parse_args(argv)
    logging.basicConfig(
        level=args.log_level.upper(), format=f"%(asctime)s {args.command}: %(message)s", datefmt="%H:%M:%S"
    )
    for library in ("can", "canopen", "matplotlib", "numba"):
        logging.getLogger(library).setLevel(logging.WARNING)
    try:
        return int(args.run(args) or 0)
    except OdsError as error:
        print(f"ods {args.command}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        sys.stderr.close()
        return 0


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="ods", description="Obstacle detection service for autonomous underwater vehicles.")
    parser.add_argument("--version", action="version", version=f"ods {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=_Parser)

    _command(commands, "run", "keep the on-board processes up", _run, ONBOARD_CONFIG)
    for process in PROCESSES.values():
        config = ONBOARD_CONFIG if process.on_board else BENCH_CONFIG
        _command(commands, process.name, f"one process: {process.job}", _process, config)

    bench = _command(commands, "bench", "whole chain against the simulated sonar and vehicle", _bench, BENCH_CONFIG)
    bench.add_argument("--seconds", type=float, help="length of the mission (default: from the configuration)")
    bench.add_argument("--out", type=Path, help="folder of the results (default: from the configuration)")

    _command(commands, "watch", "live table of obstacles and health", _watch, ONBOARD_CONFIG)
    doctor = _command(commands, "doctor", "check configuration, devices, clock, versions", _doctor, ONBOARD_CONFIG)
    doctor.add_argument("--listen", type=_seconds, default=0.0, metavar="SECONDS", help="hear sonar and INS, too")

    record = _command(
        commands, "record", "what the chain publishes, as a file that 7k software reads", _record, ONBOARD_CONFIG
    )
    record_what = record.add_mutually_exclusive_group(required=True)
    record_what.add_argument("--s7k", type=Path, metavar="FILE", help="record pings, contacts and poses; a new file")
    record_what.add_argument("--finish", type=Path, metavar="FILE", help="complete a recording that was cut off")
    record.add_argument("--seconds", type=_seconds, metavar="S", help="default: until Ctrl-C or SIGTERM")

    sonar = _command(commands, "set-sonar", "set range, power or gain, or show them", _set_sonar, ONBOARD_CONFIG)
    sonar.add_argument("--range", type=float, metavar="METRES")
    sonar.add_argument("--power", type=float, metavar="DB", help="re 1 uPa at 1 m")
    sonar.add_argument("--gain", type=float, metavar="DB")

    simulate = _command(commands, "simulate", "sonar images of a scene, with the truth behind them", _simulate)
    simulate.add_argument("scene", type=Path, metavar="SCENE.toml", nargs="?", help="what is where: config/scenes")
    simulate.add_argument("--sonar", default="seabat6012", metavar="NAME", help="file in config/sonars, or a path")
    simulate.add_argument("--out", type=Path, metavar="FILE", help=".npz pings, .s7k, or .png fan images")
    simulate.add_argument("--pings", type=_positive, metavar="N", help="default: the whole scene; one for .png")
    simulate.add_argument("--seed", type=int, metavar="N", help="instead of the scene's own")
    simulate.add_argument("--chart", type=Path, metavar="OUT.png", help="draw error against time, all model levels")
    simulate.add_argument("--table", action="store_true", help="print the time that each part of an image takes")

    detect = _offline(commands, "detect", "detections in recorded sonar images", _detect)
    detect.add_argument("file", type=Path, metavar="FILE", help=".npz pings, .s7k, .aris, Oculus .raw, .avi")
    detect.add_argument("--fan", type=Path, metavar="FAN.toml", help="geometry of the fan images of an .avi clip")
    detect.add_argument("--out", type=Path, metavar="DET.npz", help="write the detections as .npz")
    detect.add_argument("--mask", action="store_true", help="with --out: label images too")
    detect.add_argument("--json", action="store_true", help="print one JSON line a ping")
    detect.add_argument("--plot", type=Path, metavar="PICTURE.png", help="draw the images with their detections")

    track = _offline(commands, "track", "tracks of a recorded scenario", _track)
    track.add_argument("file", type=Path, metavar="SCENARIO.npz")
    track.add_argument("--out", type=Path, metavar="TRACKS.npz", required=True)

    _map_commands(commands)

    assess = commands.add_parser("assess", help="accuracy and speed of every setting, on one chart")
    _add_assessments(assess.add_subparsers(dest="what", required=True, metavar="WHAT", parser_class=_Parser))
    return parser


def _add_assessments(commands: Any) -> None:
    detect = _command(commands, "detect", "filters, detectors and attention of the pipeline", _assess_detect)
    detect.add_argument("--out", type=Path, metavar="CHART.png", help="draw the chart")
    detect.add_argument("--quick", action="store_true", help="a few images and settings, to see that it works")

    track = _command(commands, "track", "observers of the tracker", _assess_track)
    track.add_argument("--out", type=Path, metavar="CHART.png", help="draw the chart")
    track.add_argument("--seeds", type=_positive, metavar="N", help="runs of each scenario (default: 5)")
    track.add_argument("--peers", action="store_true", help="run the library Stone Soup beside ours: minutes")
    track.add_argument("--quick", action="store_true", help="a few scenarios, to see that it works")
    track.add_argument("--figures", type=Path, metavar="OUT.png", help="draw figures 6 and 7 of [SSIE] instead")
    track.add_argument("--forms", type=Path, metavar="OUT.png", help="draw where covariance updates break instead")
    track.add_argument("--save", type=Path, metavar="FOLDER", help="write the scenarios for `ods track` instead")


def _command(commands: Any, name: str, text: str, run: Any, config: Path | None = None) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(name, help=text, description=text.capitalize() + ".")
    parser.set_defaults(run=run)
    parser.add_argument("--log-level", choices=LEVELS, default="info")
    if config is not None:
        parser.add_argument("--config", type=Path, default=config, help=f"default: {config}")
    return parser


def _offline(commands: Any, name: str, text: str, run: Any) -> argparse.ArgumentParser:
    parser = _command(commands, name, text, run)
    parser.add_argument("--config", type=Path, help="take the settings from there (default: built-in settings)")
    return parser


def _map_commands(commands: Any) -> None:
    parser = commands.add_parser("map", help="the map of objects at rest: list, export, merge, prune")
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION", parser_class=_Parser)
    area: dict[str, Any] = {"type": float, "nargs": 3, "metavar": ("NORTH", "EAST", "METRES")}

    show = _command(actions, "list", "table of the objects", _map_list, ONBOARD_CONFIG)
    export = _command(actions, "export", "the objects as geographic data", _map_export, ONBOARD_CONFIG)
    prune = _command(actions, "prune", "remove objects; any one criterion is enough", _map_prune, ONBOARD_CONFIG)
    for action in (show, export, prune):
        action.add_argument("file", type=Path, metavar="MAP", nargs="?", help="default: the configuration's")
    for action in (show, export):
        action.add_argument("--within", **area, help="only objects not farther from a place than this")
    export.add_argument("--out", type=Path, metavar="FILE", required=True, help=".geojson or .gpkg (GeoPackage)")
    prune.add_argument("--existence-below", type=float, metavar="P", help="existence probability")
    prune.add_argument("--older-than", type=float, metavar="DAYS", help="days since last seen")
    prune.add_argument("--seen-fewer", type=_positive, metavar="N", help="times seen")
    prune.add_argument("--outside", **area, help="farther from a place than this")
    prune.add_argument("--dry-run", action="store_true", help="only say what would be removed")

    merge = _offline(actions, "merge", "two missions' maps as one", _map_merge)
    merge.add_argument("first", type=Path, metavar="FIRST", help="its origin and its ids are kept")
    merge.add_argument("second", type=Path, metavar="SECOND")
    merge.add_argument("--out", type=Path, metavar="MAP", required=True, help="a new file")


def _positive(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
    return int(text)


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0.0 < seconds < 1e6:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of seconds above 0")
    return seconds


def _named(path: str) -> Any:
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)


def _process(args: argparse.Namespace) -> None:
    from ods.base import settings_file
    from ods.runtime import service

    process = PROCESSES[args.command]
    settings = settings_file.load(args.config, _named(process.settings))
    service.run(_named(process.worker), process, settings)


def _run(args: argparse.Namespace) -> None:
    from ods.base.settings_file import load
    from ods.config import OnboardConfig
    from ods.runtime import supervisor

    settings = load(args.config, OnboardConfig)
    supervisor.supervise(on_board(), args.config, settings.bus.run_dir, settings.supervise)


def _bench(args: argparse.Namespace) -> int:
    from ods.bench import runner

    return runner.bench(args.config, args.seconds, args.out)


def _watch(args: argparse.Namespace) -> None:
    from ods.base.settings_file import load
    from ods.commands import watch
    from ods.config import OnboardConfig

    watch.watch(load(args.config, OnboardConfig).bus.run_dir)


def _set_sonar(args: argparse.Namespace) -> None:
    from ods.base.settings_file import load
    from ods.client import Sonar, SonarRequest
    from ods.config import OnboardConfig

    sonar = Sonar(load(args.config, OnboardConfig).bus.run_dir)
    try:
        says = sonar.ask(SonarRequest(range_m=args.range, power_db=args.power, gain_db=args.gain))
    finally:
        sonar.close()
    print(f"the sonar says: range {says.range_m} m, power {says.power_db} dB, gain {says.gain_db} dB")


def _doctor(args: argparse.Namespace) -> int:
    from ods.doctor import report

    return report.examine(args.config, args.listen)


def _record(args: argparse.Namespace) -> None:
    from ods.recording import command as record

    if args.finish:
        record.finish(args.finish)
        return
    from ods.base.settings_file import load
    from ods.config import OnboardConfig

    record.record(args.s7k, load(args.config, OnboardConfig), args.seconds)


def _simulate(args: argparse.Namespace) -> None:
    from ods.simulate import command as simulate
    from ods.simulate import files as simulate_files

    if not args.chart and not args.table and not (args.scene and args.out):
        raise OdsError("give SCENE.toml and --out, or --chart, or --table")
    if args.scene and args.out:
        simulate.simulate(args.scene, args.sonar, args.out, args.pings, args.seed)
    if args.table:
        from ods.simulate.speed import table

        table(simulate_files.find_sonar(args.sonar))
    if args.chart:
        from ods.simulate.chart import chart

        chart(simulate_files.find_sonar(args.sonar), args.chart)


def _detect(args: argparse.Namespace) -> None:
    from ods.commands import offline

    offline.detect(
        args.file, args.config, fan=args.fan, out=args.out, mask=args.mask, as_json=args.json, plot=args.plot
    )


def _track(args: argparse.Namespace) -> None:
    from ods.commands import offline

    offline.track(args.file, args.config, args.out)


def _map_list(args: argparse.Namespace) -> None:
    from ods.map import command as map_command

    map_command.list_objects(args.file, args.config, args.within)


def _map_export(args: argparse.Namespace) -> None:
    from ods.map import command as map_command

    map_command.export(args.file, args.config, args.out, args.within)


def _map_merge(args: argparse.Namespace) -> None:
    from ods.map import command as map_command

    map_command.merge_maps(args.first, args.second, args.out, args.config)


def _map_prune(args: argparse.Namespace) -> None:
    from ods.map import command as map_command
    from ods.map.prune import Criteria

    criteria = Criteria(args.existence_below, args.older_than, args.seen_fewer, args.outside)
    map_command.prune(args.file, args.config, criteria, dry_run=args.dry_run)


def _assess_detect(args: argparse.Namespace) -> None:
    from ods.assess import detect

    detect.assess(args.out, quick=args.quick)


def _assess_track(args: argparse.Namespace) -> None:
    from ods.assess.track import command

    if args.figures:
        command.draw_paper(args.figures)
    if args.forms:
        command.draw_forms(args.forms, quick=args.quick)
    if args.save:
        command.save_scenarios(args.save)
    if not (args.figures or args.forms or args.save):
        command.assess(args.out, seeds=args.seeds, with_peers=args.peers, quick=args.quick)
