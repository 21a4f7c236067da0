"""`ods calibrate`: how the sonar is mounted, from a recording of one fixed object (docs/assess/calibrate.md)."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import number
from ods.base.files.in_file import refuse_missing

DEPTH = number(-12_000.0, 12_000.0, "metres")


def add_arguments(parser: ArgumentParser) -> None:
    """Recording, and what is known of the object."""
    parser.add_argument("file", type=Path, metavar="RECORDING", help="of ods record, or .npz with poses")
    parser.add_argument("--depth", type=DEPTH, metavar="M", help="depth of the object, m down from the site's origin")


def run(args: Namespace) -> None:
    """Print mounting angles and latency with their uncertainty. Raises OdsError where the recording shows nothing."""
    refuse_missing(args.config, args.file)
    from ods.calibrate.calibration import run as work  # takes seconds: after what may be wrong

    work(args)
