"""`ods run`: keeps the on-board processes up."""

from argparse import ArgumentParser, Namespace

from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.runtime import supervisor
from ods.runtime.processes import PROCESSES, on_board


def add_arguments(_parser: ArgumentParser) -> None:
    """Add no arguments of its own."""


def run(args: Namespace) -> None:
    """Supervise until SIGTERM or SIGINT. Raises OdsError."""
    settings = load(args.config, OnboardConfig)
    recorder = [PROCESSES["record"]] if settings.record.on else []
    listen = [PROCESSES["listen"]] if settings.bus.listen else []
    bridges = [PROCESSES[f"bridge_{name}"] for name in settings.bridge.given()]
    supervisor.supervise(
        [*recorder, *listen, *bridges, *on_board()], args.config, settings.bus.run_dir, settings.supervise
    )
