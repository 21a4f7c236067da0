"""The actions done, as a Python script, and as equivalent command lines."""

import shlex
from typing import NamedTuple

import msgspec

from ods.workbench.model import actions as do
from ods.workbench.model.history import History
from ods.workbench.model.short_tables import short_tables
from ods.workbench.model.state import State

SCRIPT, COMMANDS, CONFIG, SCENE = "macro.py", "commands.sh", "tuned.toml", "scene.toml"
"""Names of a macro's files."""
DETECTIONS, OBSTACLES = "detections.jsonl", "obstacles.jsonl"
"""What script and commands write."""


class Macro(NamedTuple):
    """A recorded macro."""

    script: str
    """Python."""
    commands: str
    """For a shell, in the folder of CONFIG and SCENE."""


def macro_of(history: History) -> Macro:
    """Return what has been done since the beginning, without what was undone."""
    return Macro(_script(history), _commands(history.state))


def _script(history: History) -> str:
    return "\n".join(
        [
            '"""Recorded by the workbench of ODS: repeats the recorded actions and writes the results."""',
            "",
            "from pathlib import Path",
            "",
            "from ods.workbench.engine.files.macro_run import MacroRun",
            "",
            f"run = MacroRun({short_tables(history.steps[0].state)!r})",
            *map(_call, history.actions()),
            "run.write_results(Path(__file__).resolve().parent)",
            "",
        ]
    )


def _call(action: do.Action) -> str:
    fields = msgspec.to_builtins(action, enc_hook=str)
    name = fields.pop("do")
    return f"run.do({', '.join([repr(name), *(f'{field}={value!r}' for field, value in fields.items())])})"


def _commands(state: State) -> str:
    data = state.data
    lines = ["#!/bin/sh", "set -eu", "# The same with commands; pings without times or poses have no obstacles."]
    if data.kind == "scene":
        sonar = shlex.quote(data.sonar)
        lines.append(f"ods track {SCENE} --sonar {sonar} --config {CONFIG} --json > {OBSTACLES}")
        lines.append(f"# with the real processes: ods bench --scene {SCENE} --onboard {CONFIG} --out bench")
    elif data.kind == "file":
        file = shlex.quote(data.path)
        lines.append(f"ods detect {file} --config {CONFIG} --json > {DETECTIONS}")
        lines.append(f"ods track {file} --config {CONFIG} --json > {OBSTACLES} || rm -f {OBSTACLES}")
    else:
        lines.append("# no data was open: nothing to repeat")
    return "\n".join([*lines, ""])
