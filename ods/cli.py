"""The `ods` command: the one table of its commands. Any error is one line and exit code 2; a broken limit, a check that
fails and a recording that cannot be read are exit code 1.

A command's module has `add_arguments(parser)` and `run(args)`, which returns an exit code or None for 0. It is imported
only when its command is chosen.
"""

import argparse
import contextlib
import errno
import importlib
import io
import logging
import os
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

from ods import __version__
from ods.base.command_line.log_writer import LogWriter
from ods.base.computer import open_files
from ods.base.computer.memory import TOO_LITTLE, is_too_little
from ods.base.errors import OdsError, missing_kernels_reason, reason_of
from ods.runtime.processes import PROCESSES

BENCH_EXTRA = frozenset({"PIL", "matplotlib", "rich", "scipy", "tomli_w"})
EXPORT_EXTRA = frozenset({"foxglove", "rosbags"})
ROS2_EXTRA = frozenset({"cyclonedds", "rosbags"})
WORKBENCH_EXTRA = frozenset({"fastapi", "nicegui", "starlette", "tomlkit", "uvicorn"})
"""Modules that no on-board process needs: the optional dependencies in pyproject.toml."""
QUIETED = {
    "can": logging.WARNING, "canopen": logging.WARNING,
    "matplotlib": logging.ERROR,  # warns of each home folder that it cannot write, and draws all the same
}  # fmt: skip
"""Lowest level of other people's log lines that is shown."""
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""Of the file or terminal that standard output goes to; commands report their own files themselves."""
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "1")
"""Products are of small matrices: threads that wait for each other would cost pings more than they gain."""
INTERRUPTED = 130
"""Exit code after Ctrl-C, as of shells."""
GO_ON = frozenset({"run", "bridge", *PROCESSES})
"""Commands that do not wait for a reader of their log lines."""
NO_PLACE = (errno.ENAMETOOLONG, errno.ELOOP, errno.EACCES)
"""Of a name that no file can have, of links in a circle, and of a folder that may not be looked into."""
LEVELS = ("debug", "info", "warning", "error")
NO_CONFIG, BUILT_IN_SETTINGS, ONBOARD, BENCH = "", "built-in settings", "config/onboard.toml", "config/bench.toml"
RECORDED = "the recording's own"
"""Default configurations; a command of the first kind takes none."""


class Command(NamedTuple):
    """One row of the command table."""

    name: str
    """Two words: a command of one of GROUPS."""
    module: str
    help: str
    config: str


GROUPS = {
    "map": ("ACTION", "the map of static objects: list, export, merge, prune"),
    "keys": ("ACTION", "keys of clients on other computers: make, list, revoke"),
    "veto": ("ACTION", "operator's vetoes: ignore, forget or restore obstacles"),
    "bridge": ("NAME", "send obstacles to other planners and displays"),
    "assess": ("WHAT", "accuracy and speed of every setting, on one chart"),
}
COMMANDS = (
    Command("run", "ods.commands.run", "start the on-board processes and keep them running", ONBOARD),
    *(Command(process.command, f"ods.commands.{'bridge' if ' ' in process.command else 'process'}",
              f"one process: {process.job}", ONBOARD if process.on_board else BENCH)
      for process in PROCESSES.values() if process.name not in ("record", "listen")),
    Command("listen", "ods.commands.listen", "one process: topics for other computers, by tcp with keys", ONBOARD),
    Command("keys make", "ods.commands.keys.make", "make a key for a client on another computer", ONBOARD),
    Command("keys list", "ods.commands.keys.list", "list the clients that may listen", ONBOARD),
    Command("keys revoke", "ods.commands.keys.revoke", "revoke the key of a client", ONBOARD),
    Command("veto ignore", "ods.commands.veto.ignore", "ignore an obstacle for some time", ONBOARD),
    Command("veto region", "ods.commands.veto.region", "ignore static obstacles in a region for some time", ONBOARD),
    Command("veto forget", "ods.commands.veto.forget", "drop an obstacle; its next echoes start a new one", ONBOARD),
    Command("veto restore", "ods.commands.veto.restore", "end a veto before it expires", ONBOARD),
    Command("veto list", "ods.commands.veto.list", "vetoes that hold", ONBOARD),
    Command("bench", "ods.bench.command", "whole chain against the simulated sonar and vehicle", BENCH),
    Command("watch", "ods.commands.watch", "live table of obstacles and health", ONBOARD),
    Command("doctor", "ods.doctor.command", "check configuration, devices, clock, versions", ONBOARD),
    Command("record", "ods.commands.record", "record all messages to files", ONBOARD),
    Command("info", "ods.commands.info", "show the contents of a recording", NO_CONFIG),
    Command("export", "ods.export.command", "convert a recording for Lichtblick, ROS 2, pandas, 7k or maps", RECORDED),
    Command("replay", "ods.replay.command", "replay a recording, live or as a check", RECORDED),
    Command("set-sonar", "ods.commands.set_sonar", "set range, power or gain, or show them", ONBOARD),
    Command("simulate", "ods.simulate.command", "simulate sonar images of a scene, with the truth", NO_CONFIG),
    Command("detect", "ods.commands.detect", "detections in recorded sonar images", BUILT_IN_SETTINGS),
    Command("calibrate", "ods.calibrate.command", "find the sonar's mounting from a recording of one object", ONBOARD),
    Command("track", "ods.track.command", "obstacles of recorded or simulated pings", BUILT_IN_SETTINGS),
    Command("missions", "ods.missions.command", "missions in random worlds, with a planner in the loop", NO_CONFIG),
    Command("workbench", "ods.workbench.command", "tune everything in a browser: sliders, images, tracks, scenes",
            BUILT_IN_SETTINGS),
    Command("map list", "ods.map.commands.list", "table of the objects", ONBOARD),
    Command("map export", "ods.map.commands.export", "the objects as geographic data", ONBOARD),
    Command("map prune", "ods.map.commands.prune", "remove objects; any one criterion is enough", ONBOARD),
    Command("map merge", "ods.map.commands.merge", "merge the maps of two missions", BUILT_IN_SETTINGS),
    Command("assess detect", "ods.assess.detection.command", "the pipeline's filters, detectors, attention",
            BUILT_IN_SETTINGS),
    Command("assess sea", "ods.assess.sea.command", "false obstacles and tracked objects over sea-beds",
            BUILT_IN_SETTINGS),
    Command("assess track", "ods.assess.track.command", "observers of the tracker", BUILT_IN_SETTINGS),
)  # fmt: skip


def main(argv: Sequence[str] | None = None) -> int:
    """Run the `ods` command; return its exit code: 0 good, 1 a limit broken, a recording unreadable, 2 other errors."""
    try:
        return _run(argv)
    except KeyboardInterrupt:  # also while the command is imported: seconds, on a busy computer
        return INTERRUPTED
    except Exception as error:
        if not is_too_little(error):
            raise
        print(f"ods: {TOO_LITTLE}", file=sys.stderr)
        return 2


def _run(argv: Sequence[str] | None) -> int:
    os.environ.setdefault(*ONE_THREAD)
    _print_any_name()
    for library, least in QUIETED.items():
        logging.getLogger(library).setLevel(least)
    args = _parser().parse_args(argv)
    logging.basicConfig(
        level=args.log_level.upper(),
        format=f"%(asctime)s {_logs_as(args)}: %(message)s",
        datefmt="%H:%M:%S",
        handlers=[LogWriter()] if args.command in GO_ON else None,
    )
    try:
        _refuse_no_place(value for name, value in vars(args).items() if name != "config")  # not all need theirs
        open_files.allow_enough()
        code = int(args.run(args) or 0)
        if sys.stdout is not None:
            sys.stdout.flush()  # or a full disk is noticed too late to be reported
        return code
    except OdsError as error:
        _complain(args, str(error))
        return error.exit_code
    except ImportError as error:
        _complain(args, _missing(error))
        return 2
    except UnicodeEncodeError as error:
        _complain(args, reason_of(error))
        return 2
    except BrokenPipeError:
        sys.stderr.close()
        return 0
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise
        _complain(args, f"cannot write its output: {reason_of(error)}")
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # for what is left of it
        return 2


def _complain(args: argparse.Namespace, text: str) -> None:
    """Print why the command ends; where that cannot be written, as to a log on a full disk, the exit code says it."""
    with contextlib.suppress(OSError):
        print(f"ods {args.command}: {text}", file=sys.stderr, flush=True)


def _logs_as(args: argparse.Namespace) -> str:
    return f"bridge {args.name}" if args.command == "bridge" else str(args.command)


def _refuse_no_place(values: Iterable[Any]) -> None:
    """Raise OdsError for a path that cannot be asked for: commands ask for them in many ways, which fail in as many."""
    for value in values:
        if isinstance(value, list):
            _refuse_no_place(value)
        elif isinstance(value, Path):
            try:
                value.stat()
            except OSError as error:
                if error.errno in NO_PLACE:
                    raise OdsError(f"{value}: {reason_of(error)}") from error


def _print_any_name() -> None:
    """Let what the locale cannot write, as in the name of a file, not end the command that prints it."""
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.encoding != "utf-8":
        sys.stdout.reconfigure(errors="backslashreplace")


def _missing(error: ImportError) -> str:
    """Return the line that says what to build or install, or raise `error` again where neither would help."""
    if why := missing_kernels_reason(error):
        return why
    module = (error.name or "").partition(".")[0]
    for extra, modules in (
        ("bench", BENCH_EXTRA),
        ("export", EXPORT_EXTRA),
        ("ros2", ROS2_EXTRA),
        ("workbench", WORKBENCH_EXTRA),
    ):
        if module in modules:
            return f"needs pip install 'ods[{extra}]': there is no {error.name}"
    raise error


class _Parser(argparse.ArgumentParser):
    """Gets the arguments of its command's module when that command is chosen."""

    module = ""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        if self.module:
            try:
                chosen = importlib.import_module(self.module)
            except ImportError as error:
                self.exit(2, f"{self.prog}: {_missing(error)}\n")
            chosen.add_arguments(self)
            self.set_defaults(run=chosen.run)
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="ods", description="Obstacle detection service for autonomous underwater vehicles.")
    parser.add_argument("--version", action="version", version=f"ods {__version__}")
    groups = {"": parser.add_subparsers(dest="command", required=True, metavar="COMMAND")}
    for row in COMMANDS:
        group, _, name = row.name.rpartition(" ")
        if group not in groups:
            metavar, text = GROUPS[group]
            inner = groups[""].add_parser(group, help=text)
            groups[group] = inner.add_subparsers(dest=metavar.lower(), required=True, metavar=metavar)
        _add_command(
            groups[group].add_parser(name, help=row.help, description=f"{row.help[0].upper()}{row.help[1:]}."), row
        )
    return parser


def _add_command(parser: _Parser, row: Command) -> None:
    parser.module = row.module
    parser.add_argument("--log-level", choices=LEVELS, default="info")
    if row.config in (BUILT_IN_SETTINGS, RECORDED):
        parser.add_argument("--config", type=Path, help=f"configuration file (default: {row.config})")
    elif row.config != NO_CONFIG:
        parser.add_argument("--config", type=Path, default=Path(row.config), help=f"default: {row.config}")
