"""`ods record`: everything on the bus to files; the record process, too."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import duration_s
from ods.base.files.in_file import text_of
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.recording.errors import RecordingError
from ods.recording.record_s7k import record_s7k
from ods.recording.repair import repair
from ods.recording.service import RecordWorker
from ods.recording.settings import RecordConfig
from ods.runtime.processes import PROCESSES
from ods.runtime.service import report_exit_reason, run_worker


def add_arguments(parser: ArgumentParser) -> None:
    """Record, or finish what was cut off."""
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--out", type=Path, metavar="DIR", help="record everything (default: in record.folder)")
    what.add_argument("--s7k", type=Path, metavar="FILE", help="record pings, contacts and poses; a new file")
    what.add_argument("--finish", type=Path, metavar="PATH", help="complete truncated recordings: file, folder")
    what.add_argument(
        "--is-on", action="store_true", help="exit with 0 if `[record] on = true`, otherwise 1; for systemd"
    )
    parser.add_argument("--seconds", type=duration_s, metavar="S", help="default: until Ctrl-C or SIGTERM")


def run(args: Namespace) -> int:
    """Run the command; return the exit code. Raises OdsError."""
    if args.is_on:
        return 0 if load(args.config, OnboardConfig).record.on else 1
    if args.finish:
        repair(args.finish)
    elif args.s7k:
        config = load(args.config, OnboardConfig)
        origin_deg = config.site.latitude_deg, config.site.longitude_deg
        record_s7k(args.s7k, config.bus.run_dir, origin_deg, args.seconds)
    else:
        _record(args)
    return 0


def _record(args: Namespace) -> None:
    process = PROCESSES["record"]
    with report_exit_reason(process.name) as home:
        config = load(args.config, OnboardConfig)
        home.run_dir = config.bus.run_dir
        settings = RecordConfig(
            record=config.record,
            tracker=config.tracker,
            text=text_of(args.config),
            out=None if args.out is None else _new(args.out),
            seconds=args.seconds,
        )
        if settings.out is None and config.record.folder is None:
            raise RecordingError(f"{args.config}: record.folder: missing; set it, or give --out DIR")
        run_worker(RecordWorker, process, config.bus.run_dir, settings)


def _new(folder: Path) -> Path:
    if any(folder.glob("*.mcap")):
        raise RecordingError(f"{folder}: already contains a recording, which is not overwritten")
    return folder.resolve()
