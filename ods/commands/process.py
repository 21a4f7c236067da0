"""`ods NAME` for each row of the process table: one process."""

import importlib
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from ods.base.settings_file import load
from ods.config import part_of
from ods.runtime.processes import PROCESSES, Process
from ods.runtime.service import report_exit_reason, run_worker


def add_arguments(_parser: ArgumentParser) -> None:
    """Add no arguments of its own."""


def run(args: Namespace) -> None:
    """Run the process that the command is named after until SIGTERM or SIGINT. Raises OdsError."""
    run_process(PROCESSES[args.command], args.config)


def run_process(process: Process, file: Path) -> None:
    """Run a process by a configuration until SIGTERM or SIGINT. Raises OdsError."""
    with report_exit_reason(process.name) as home:
        config = load(file, _named(process.config))
        home.run_dir = config.bus.run_dir
        run_worker(_named(process.worker), process, config.bus.run_dir, part_of(config, _named(process.settings)))


def _named(path: str) -> Any:
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)
