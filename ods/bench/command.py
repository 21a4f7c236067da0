"""`ods bench`: the whole chain against the simulated sonar and vehicle, judged by limits and drawn."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.command_line.arguments import duration_s
from ods.base.files.in_file import refuse_missing
from ods.plots.style import add_style


def add_arguments(parser: ArgumentParser) -> None:
    """What goes before the configuration."""
    parser.add_argument("--scene", type=Path, help="scene to simulate (default: from the configuration)")
    parser.add_argument("--onboard", type=Path, help="configuration under test (default: from the configuration)")
    parser.add_argument("--seconds", type=duration_s, help="length of the mission (default: from the configuration)")
    parser.add_argument("--out", type=Path, help="folder of the results (default: from the configuration)")
    parser.add_argument("--record", type=Path, metavar="DIR", help="record everything to a new folder in this one")
    add_style(parser)


def run(args: Namespace) -> int:
    """Run the bench; return 1 when a limit is broken and a busy computer does not explain it. Raises OdsError."""
    refuse_missing(args.config)
    from ods.bench.mission import run as work  # takes seconds: after what may be wrong

    return work(args)
