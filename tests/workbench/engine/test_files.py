"""What can be opened is listed, what lies elsewhere is not opened, and nothing is written over."""

import os
from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.base.files.shipped import shipped_file
from ods.workbench.engine.files import openable as files
from ods.workbench.engine.files.folders import new_beside
from ods.workbench.engine.files.openable import openable, opening, shipped_scenes
from ods.workbench.model.apply import apply
from ods.workbench.model.state import State


def test_recordings_and_scenes_are_listed_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "deep" / ".git").mkdir(parents=True)
    for name in ("a.npz", "deep/b.mcap", "deep/.git/c.npz", "notes.txt", "config.toml"):
        (tmp_path / name).write_bytes(b"[bus]\n")
    (tmp_path / "scene.toml").write_text(shipped_file("scenes/figure11.toml").read_text())
    assert {each.name for each in openable([tmp_path, tmp_path / "deep"])} == {"a.npz", "deep/b.mcap", "scene.toml"}


def test_what_is_no_file_is_passed_over_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "x.toml")
    (tmp_path / "y.toml").symlink_to("/dev/zero")
    assert openable([tmp_path]) == []
    for name in ("x.toml", "y.toml"):
        with pytest.raises(OdsError):
            opening(tmp_path / name, [tmp_path])


def test_every_scene_that_is_listed_opens() -> None:
    scenes = shipped_scenes()
    assert "figure11.toml" in {each.name for each in scenes}
    for each in scenes:
        assert apply(State(), opening(each.path, [])).scene is not None


def test_files_elsewhere_are_not_opened(tmp_path: Path) -> None:
    (tmp_path / "a.npz").touch()
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "link.npz").symlink_to(tmp_path / "a.npz")
    for path in (tmp_path / "a.npz", tmp_path / "in" / "link.npz", "/etc/hostname", "in/../../x.npz", "a\0b"):
        with pytest.raises(OdsError):
            opening(path, [tmp_path / "in"])
    with pytest.raises(OdsError, match="no such file"):
        opening(tmp_path / "in" / "none.npz", [tmp_path / "in"])


def keep_dropped(name: str, content: bytes, folders: list[Path]) -> Path:
    wanted = files.place_of_dropped(name, folders)
    with new_beside(wanted) as (new, writing):
        writing.write(content)
        writing.close()
        return files.keep_dropped(new, wanted)


def test_a_file_dropped_never_takes_anothers_place(tmp_path: Path) -> None:
    first = keep_dropped("../../x.npz", b"1", [tmp_path])
    assert (first, keep_dropped("x.npz", b"1", [tmp_path])) == (tmp_path / "x.npz", first)
    assert keep_dropped("x.npz", b"2", [tmp_path]) == tmp_path / "x-1.npz"
    assert keep_dropped("x.npz", b"2", [tmp_path]) == tmp_path / "x-1.npz"
    assert keep_dropped("x.npz", b"3" * 999, [tmp_path]).read_bytes() == b"3" * 999
    assert first.read_bytes() == b"1"
    for name in ("x.py", "x", ""):
        with pytest.raises(OdsError, match="ending"):
            keep_dropped(name, b"1", [tmp_path])
    assert sorted(each.name for each in tmp_path.iterdir()) == ["x-1.npz", "x-2.npz", "x.npz"]


def test_a_file_that_is_not_dropped_to_its_end_is_not_kept(tmp_path: Path) -> None:
    with new_beside(tmp_path / "x.npz") as (_, writing):
        writing.write(b"1" * 999)
    assert list(tmp_path.iterdir()) == []
