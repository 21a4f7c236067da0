"""Script and commands of a macro come to the same as what was done."""

import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from ods.base.files.shipped import shipped_file
from ods.offline.mission import Mission
from ods.offline.recorded import pings_of
from ods.offline.source import open_source
from ods.pipeline.offline import detect_pings, json_line
from ods.sim_sonar.scene.timeline import load_scene
from ods.workbench.engine.files.config_file import ConfigFile, load_config
from ods.workbench.engine.files.macro_run import write_macro
from ods.workbench.model import actions as do
from ods.workbench.model.history import History
from ods.workbench.model.macro import COMMANDS, DETECTIONS, OBSTACLES, SCRIPT
from ods.workbench.model.paths import tables_of
from ods.workbench.model.state import DataReference, State, Tuning

pytestmark = pytest.mark.slow

PINGS = Path("tests/data/oculus/three_pings_8bit.raw").resolve()


def _history(loaded: ConfigFile, *actions: do.Action) -> History:
    history = History.of(State(tuning=Tuning(config=loaded.config)))
    for action in actions:
        history = history.after(action)
    return history


def _results(folder: Path) -> tuple[str, str]:
    files = [folder / DETECTIONS, folder / OBSTACLES]
    texts = [file.read_text() if file.exists() else "" for file in files]
    for file in files:
        file.unlink(missing_ok=True)
    return texts[0], texts[1]


def _both(folder: Path) -> tuple[tuple[str, str], tuple[str, str]]:
    """Run the script, then the commands, as somebody would who was given the folder."""
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, [str(Path.cwd()), os.environ.get("PYTHONPATH", "")]))
    environment.pop("COVERAGE_PROCESS_START", None)
    subprocess.run([sys.executable, SCRIPT], cwd=folder, env=environment, check=True)
    by_script = _results(folder)
    subprocess.run(["sh", COMMANDS], cwd=folder, env=environment, check=True, capture_output=True)
    return by_script, _results(folder)


def test_script_and_commands_write_the_same_detections_of_a_file(tmp_path: Path) -> None:
    loaded = load_config(shipped_file("onboard-oculus.toml"))
    history = _history(
        loaded,
        do.OpenData(DataReference(kind="file", path=str(PINGS))),
        do.SetSetting("pipeline.min_range_m", 1.0),
        do.AddStage("filter.median", 1),
        do.SetSetting("pipeline.stage[1].window", 5),
        do.SetView("palette", "gray"),
        do.KeepAsB(),
    )
    write_macro(history, loaded, tmp_path / "macro")
    by_script, by_commands = _both(tmp_path / "macro")
    assert by_script == by_commands
    wanted = [json_line(result) for result in detect_pings(pings_of(PINGS).pings, history.state.tuning.pipeline())]
    assert by_script[0].splitlines() == wanted


def test_script_and_commands_write_the_same_obstacles_of_a_scene(tmp_path: Path) -> None:
    loaded = load_config()
    scene = load_scene(shipped_file("scenes/figure11.toml")).file
    history = _history(
        loaded,
        do.OpenData(DataReference(kind="scene"), tables_of(scene)),
        do.SetScene("duration_s", 1.5),
        do.AddObject("sphere", (20.0, 3.0, 5.0)),
        do.SetSetting("tracker.life.confirm_echoes", 4),
    )
    write_macro(history, loaded, tmp_path / "macro")
    by_script, by_commands = _both(tmp_path / "macro")
    assert by_script == by_commands
    assert by_script[1].count("\n") > 5
    source = open_source(tmp_path / "macro" / "scene.toml", sonar="seabat6012")
    steps = Mission(history.state.tuning.mission()).steps(source.pings, source.poses)
    assert by_script[1].splitlines() == [msgspec.json.encode(step.list).decode() for step in steps]


@pytest.mark.parametrize("data", [DataReference(kind="none"), DataReference(kind="live")], ids=lambda data: data.kind)
def test_without_data_nothing_is_written(tmp_path: Path, data: DataReference) -> None:
    loaded = load_config()
    history = _history(loaded, do.OpenData(data), do.KeepAsB())
    write_macro(history, loaded, tmp_path)
    assert _both(tmp_path) == (("", ""), ("", ""))
