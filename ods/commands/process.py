"""`ods NAME` for each row of the process table: one process."""

import importlib
from argparse import ArgumentParser, Namespace
from typing import Any

from ods.base import settings_file
from ods.runtime import service
from ods.runtime.processes import PROCESSES


def add_arguments(_parser: ArgumentParser) -> None:
    """It has none of its own."""


def run(args: Namespace) -> None:
    """Run the process that the command is named after until SIGTERM or SIGINT. Raises OdsError."""
    process = PROCESSES[args.command]
    settings = settings_file.load(args.config, _named(process.settings))
    service.run(_named(process.worker), process, settings)


def _named(path: str) -> Any:
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)
