"""`ods replay`: a recording played again."""

import math
from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import number
from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.recording.mcap.reader import Recording, open_recording
from ods.replay.live import Wanted, play
from ods.runtime import bus
from ods.runtime.run_dir import default_run_dir

SECONDS = number(0.0, 1e9, "seconds")


def add_arguments(parser: ArgumentParser) -> None:
    """Recording, and how."""
    parser.add_argument("recording", type=Path, metavar="RECORDING", help="file or folder that `ods record` wrote")
    how = parser.add_mutually_exclusive_group(required=True)
    how.add_argument(
        "--live",
        action="store_true",
        help="publish its messages at the recorded pace, as if its processes were running",
    )
    how.add_argument(
        "--check",
        action="store_true",
        help="run pipeline and tracker again and compare the output with the recorded one",
    )
    live = parser.add_argument_group("live")
    live.add_argument(
        "--speed", type=number(0.01, 100.0), default=1.0, metavar="N", help="0.01 to 100 times as fast, default: 1"
    )
    live.add_argument("--from", type=SECONDS, default=0.0, dest="begin", metavar="S", help="of the recording")
    live.add_argument("--to", type=SECONDS, default=math.inf, dest="end", metavar="S", help="of the recording")
    live.add_argument("--loop", action="store_true", help="repeat until Ctrl-C")
    live.add_argument("--topics", nargs="+", choices=tuple(bus.TOPICS), default=tuple(bus.TOPICS), metavar="TOPIC",
                      help=f"only these of {', '.join(bus.TOPICS)}; processes of the others may run")  # fmt: skip
    live.add_argument("--run-dir", type=Path, help=f"run folder of the processes, default: {default_run_dir()}")


def run(args: Namespace) -> int:
    """Replay; return 1 when a check does not hold. Raises OdsError."""
    recording = open_recording(args.recording)
    if args.check:
        return _check(args, recording)
    if args.config:
        raise OdsError("--config: goes with --check")
    wanted = Wanted(args.speed, (args.begin, args.end), args.loop, args.topics)
    played = play(recording.messages, args.run_dir or default_run_dir(), wanted)
    lost = [f"{what} {count}" for what, count in sorted((played.losses + recording.losses).items())]
    print(", ".join([f"{args.recording}: {played.messages} messages published", *lost]))
    return 0


def _check(args: Namespace, recording: Recording) -> int:
    if args.config:
        from ods.replay.run_comparison import compare_runs, print_differences

        print_differences(*compare_runs(recording, load(args.config, OnboardConfig)))
        return 0
    from ods.replay.check import check, report

    result = check(recording)
    result.counters.update(recording.losses)
    report(result, args.recording)
    return 0 if result.holds else 1
