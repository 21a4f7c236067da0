"""`ods doctor`: prints what every examination has found."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import duration_s
from ods.base.command_line.terminal import coloured
from ods.doctor.report import findings

LEVEL_COLOURS = {"good": "green", "note": "yellow", "wrong": "red"}


def add_arguments(parser: ArgumentParser) -> None:
    """How long to listen."""
    parser.add_argument(
        "--listen", type=duration_s, default=0.0, metavar="SECONDS", help="also receive data from sonar and INS"
    )


def run(args: Namespace) -> int:
    """Examine this machine and a configuration; return 1 when something is wrong."""
    return print_report(args.config, args.listen)


def print_report(config: Path, listen_s: float = 0.0) -> int:
    """Print the report on this machine and `config`; return 0, or 1 when something is wrong.

    listen_s: listen to sonar and navigation source for this time, s.
    """
    wrong = 0
    for item in findings(config, listen_s):
        wrong += item.level == "wrong"
        print(coloured(f"{item.level:6}", LEVEL_COLOURS[item.level]), f"{item.subject}: {item.text}")
    print(f"{wrong} wrong" if wrong else "nothing is wrong")
    return 1 if wrong else 0
