"""The gallery: its demos, and results made once and kept."""

import shutil
from pathlib import Path

import msgspec
import pytest
from PIL import Image

from ods.sim_sonar.by_name import find_scene
from ods.workbench.engine.data import open_data
from ods.workbench.engine.gallery import demos as gallery, results as gallery_results
from ods.workbench.engine.gallery.demos import Demo, demos
from ods.workbench.engine.gallery.results import gallery_folder, kept, made
from ods.workbench.engine.scene.view import built
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.state import State
from tests.workbench.engine.test_own_process import keeping

DATA = Path(__file__).parents[2] / "data"
BASE = State()
SHORT = Demo("short", "Short", ("a", "b", "c"), msgspec.structs.replace(find_scene("figure11").file, duration_s=2.0))


def test_simulated_exhibits_are_always_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As from a wheel, which has no tests/data."""
    monkeypatch.setattr(gallery, "SOURCES", tmp_path / "nowhere")
    shown = demos([tmp_path])
    assert [each.key for each in shown if not each.missing] == [
        "figure11",
        "worked_example",
        "rough",
        "approach",
        "faults",
    ]
    assert {each.key: each.missing for each in shown if each.missing} == {
        "aris": "no .aris file under the workbench's folders; `--folder DIR` adds one",
        "oculus": "no .raw file under the workbench's folders; `--folder DIR` adds one",
        "didson": "no .avi file under the workbench's folders; `--folder DIR` adds one",
    }
    for each in shown:
        assert all(sentence.endswith((".", ").")) for sentence in each.look)
        if each.scene is not None:
            built(each.scene)


def test_recordings_of_the_source_tree_are_shown_and_a_clip_needs_its_geometry(tmp_path: Path) -> None:
    (tmp_path / "clip.avi").write_bytes(b"RIFF")
    shown = {each.key: each for each in demos([tmp_path])}
    assert shown["aris"].file == DATA / "aris" / "sample.aris"
    assert shown["oculus"].file == DATA / "oculus" / "three_pings_8bit.raw"
    assert "clip.toml beside it" in shown["didson"].missing
    (tmp_path / "clip.toml").write_text("")
    assert {each.key: each for each in demos([tmp_path])}["didson"].file == tmp_path / "clip.avi"


def test_an_exhibit_opens_in_the_other_menus() -> None:
    for each in demos([DATA]):
        if not each.missing:
            state = apply(BASE, do.SetState(each.state(BASE), each.title))
            assert len(open_data(state.data, state.scene, [DATA]).pings) > 0


def test_what_was_made_is_kept_until_version_or_configuration_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert kept(SHORT, BASE, tmp_path) is None
    shares: list[float] = []
    result = made(SHORT, BASE, tmp_path, keeping(shares))
    assert result is not None
    assert shares[-1] == 1.0
    assert result.facts.startswith("14 pings")
    assert [Image.open(file).width for file in result.pictures] == [1100]
    assert kept(SHORT, BASE, tmp_path) == result
    assert made(SHORT, BASE, tmp_path, keeping(shares)) == result
    assert shares.count(1.0) == 1
    tuned = apply(BASE, do.SetSetting("tracker.observer", "independent"))
    assert kept(SHORT, tuned, tmp_path) is None
    monkeypatch.setattr(gallery, "__version__", "9.9.9")
    assert kept(SHORT, BASE, tmp_path) is None


def test_a_cache_that_was_spoilt_is_made_again(tmp_path: Path) -> None:
    demo = {each.key: each for each in demos([])}["oculus"]
    result = made(demo, BASE, tmp_path)
    assert result is not None
    assert result.facts.startswith("3 pings of 256 x ")
    result.pictures[0].unlink()
    assert kept(demo, BASE, tmp_path) is None
    assert made(demo, BASE, tmp_path) == result
    next(tmp_path.glob("oculus-*.json")).write_text("{")
    assert kept(demo, BASE, tmp_path) is None


def test_making_can_be_given_up(tmp_path: Path) -> None:
    shares: list[float] = []
    assert made(SHORT, BASE, tmp_path, keeping(shares, most=3)) is None
    assert kept(SHORT, BASE, tmp_path) is None


@pytest.mark.parametrize("home", ["", "/dev/null"])
def test_without_a_home_results_are_kept_for_the_process(home: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ODS_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", home)
    folder = gallery_results.gallery_folder.__wrapped__()
    assert folder.is_dir()
    shutil.rmtree(folder)


def test_the_users_cache_folder_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ODS_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert gallery_folder.__wrapped__() == tmp_path / "ods" / "gallery"
