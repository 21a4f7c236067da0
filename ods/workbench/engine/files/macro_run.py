"""A recorded macro: written to a folder, and done again by its script."""

import contextlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import msgspec

from ods.base.errors import OdsError, reason_of
from ods.offline.mission import Mission
from ods.offline.recorded import pings_of
from ods.offline.source import Source, open_source
from ods.pipeline.offline import detect_pings, json_line
from ods.workbench.engine.files.config_file import ConfigFile, saving
from ods.workbench.model.actions import Step
from ods.workbench.model.apply import apply
from ods.workbench.model.history import History
from ods.workbench.model.macro import COMMANDS, CONFIG, DETECTIONS, OBSTACLES, SCENE, SCRIPT, macro_of
from ods.workbench.model.paths import typed
from ods.workbench.model.scene.text import scene_text
from ods.workbench.model.state import State


def write_macro(history: History, loaded: ConfigFile, folder: Path) -> None:
    """Write script and commands, with the files that they need, into a folder that is made. Raises OdsError."""
    macro, state = macro_of(history), history.state
    files = {SCRIPT: macro.script, COMMANDS: macro.commands, CONFIG: saving(loaded, state.tuning).text}
    if state.scene is not None:
        files[SCENE] = scene_text(state.scene)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise OdsError(f"{folder}: {reason_of(error)}") from error


class MacroRun:
    """Runs a macro script, action by action."""

    def __init__(self, start: dict[str, Any]) -> None:
        """start: tables of the state before the first action. Raises PathError."""
        self.state = typed(start, State)

    def do(self, name: str, /, **fields: Any) -> None:
        """Do one action, by its tag. Raises PathError."""
        self.state = apply(self.state, msgspec.convert({"do": name, **fields}, Step, dec_hook=lambda kind, v: kind(v)))

    def write_results(self, folder: Path) -> None:
        """Write the detections of a file and, where pings have times and poses, obstacle lists, as JSON lines.

        Raises OdsError.
        """
        data, settings = self.state.data, self.state.tuning.mission()
        if data.kind == "file":
            file = Path(data.path)
            results = detect_pings(pings_of(file).pings, settings.pipeline)
            _write(folder / DETECTIONS, map(json_line, results))
            with contextlib.suppress(OdsError):  # single images, or no poses: nothing can be tracked
                self._write_obstacles(open_source(file, sonar=data.sonar), folder)
        elif data.kind == "scene" and self.state.scene is not None:
            (folder / SCENE).write_text(scene_text(self.state.scene), encoding="utf-8")
            self._write_obstacles(open_source(folder / SCENE, sonar=data.sonar), folder)

    def _write_obstacles(self, source: Source, folder: Path) -> None:
        steps = Mission(self.state.tuning.mission()).steps(source.pings, source.poses)
        _write(folder / OBSTACLES, (msgspec.json.encode(step.list).decode() for step in steps))


def _write(file: Path, lines: Iterable[str]) -> None:
    file.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
