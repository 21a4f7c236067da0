"""`ods bridge NAME`: one bridge's process."""

from argparse import ArgumentParser, Namespace

from ods.base.settings_file import load
from ods.commands.process import run_process
from ods.config import OnboardConfig
from ods.runtime.processes import PROCESSES


def add_arguments(parser: ArgumentParser) -> None:
    """Run it, or ask whether the configuration has it."""
    parser.add_argument(
        "--is-on", action="store_true", help="exit with 0 if its table is configured, otherwise 1; for systemd"
    )


def run(args: Namespace) -> int:
    """Run the command; return the exit code. Raises OdsError."""
    if args.is_on:
        return 0 if args.name in load(args.config, OnboardConfig).bridge.given() else 1
    run_process(PROCESSES[f"bridge_{args.name}"], args.config)
    return 0
