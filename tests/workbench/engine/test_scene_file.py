"""Scenes opened and saved."""

from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.base.files.shipped import shipped_file
from ods.base.settings_file import load
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.files.openable import opening, shipped_scenes
from ods.workbench.engine.scene.file import proposed, save, saving, shipped_sonars
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.paths import with_value
from ods.workbench.model.state import State

SCENES = {each.name: each.path for each in shipped_scenes()}


def opened(path: Path, folder: Path) -> SceneFile:
    scene = apply(State(), opening(path, [folder])).scene
    assert scene is not None
    return scene


@pytest.mark.parametrize("name", SCENES)
def test_every_shipped_scene_opens_and_survives_saving(name: str, tmp_path: Path) -> None:
    scene = opened(SCENES[name], tmp_path)
    assert scene == load(SCENES[name], SceneFile)
    saved = saving(scene, str(tmp_path / "scene.toml"), [tmp_path])
    save(saved)
    assert opened(saved.path, tmp_path) == scene
    assert saving(scene, str(saved.path), [tmp_path]).difference == ""


def test_the_difference_is_what_was_changed_and_comments_stay(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(SCENES["figure11.toml"].read_text())
    scene = with_value(opened(file, tmp_path), "objects[1].radius_m", 4.5)
    saved = saving(scene, str(file), [tmp_path])
    changes = [line for line in saved.difference.splitlines()[2:] if line[0] in "+-"]
    assert changes == ["-radius_m = 3.0", "+radius_m = 4.5"]
    assert file.read_text() == SCENES["figure11.toml"].read_text()
    save(saved)
    assert opened(file, tmp_path) == scene
    assert "found none of significance" in file.read_text()


def test_objects_put_in_and_taken_out_are_saved(tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    file.write_text(SCENES["figure11.toml"].read_text())
    state = State(scene=opened(file, tmp_path))
    for action in (do.RemoveObject(0), do.AddObject("plane", (50.0, 3.0, 20.0)), do.RemoveObject(1)):
        state = apply(state, action)
    assert state.scene is not None
    save(saving(state.scene, str(file), [tmp_path]))
    assert opened(file, tmp_path) == state.scene


@pytest.mark.parametrize("path", ["elsewhere/a.toml", "inside/../../a.toml", "inside/a.txt", ""])
def test_no_scene_is_written_elsewhere(path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "inside").mkdir()
    with pytest.raises(OdsError):
        saving(load(SCENES["empty.toml"], SceneFile), path, [tmp_path / "inside"])


def test_a_folder_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    saved = saving(load(SCENES["empty.toml"], SceneFile), str(tmp_path / "none" / "a.toml"), [tmp_path])
    with pytest.raises(OdsError, match=r"a\.toml: no such file"):
        save(saved)


def test_the_sonars_that_come_with_ods_are_reported() -> None:
    assert {"seabat6012", "seabat6012_3plane", "oculus_m750d", "multibeam512"} <= set(shipped_sonars())


def test_a_file_that_came_with_ods_is_never_proposed(tmp_path: Path) -> None:
    shipped = shipped_file("scenes/figure11.toml")
    folders = [tmp_path, shipped.resolve().parents[2]]  # as from a source tree
    assert proposed(str(shipped), folders) == tmp_path / "figure11.toml"
    (tmp_path / "figure11.toml").write_text("")
    assert proposed(str(shipped), folders) == tmp_path / "figure11-2.toml"
    assert proposed(str(tmp_path / "figure11.toml"), folders) == tmp_path / "figure11.toml"
    assert proposed("", folders) == tmp_path / "scene.toml"
