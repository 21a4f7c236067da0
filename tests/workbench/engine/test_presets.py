"""What is kept under a name comes back; nothing else is written or read."""

from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.workbench.engine.files.presets import load_preset, preset_names, save_preset
from ods.workbench.model.state import State
from tests.workbench.model.test_history import START


def test_a_preset_comes_back(tmp_path: Path) -> None:
    save_preset("rocky, calm", START, [tmp_path])
    save_preset("a", State(), [tmp_path])
    assert preset_names([tmp_path]) == ["a", "rocky, calm"]
    assert load_preset("rocky, calm", State(), [tmp_path]) == START


@pytest.mark.parametrize("name", ["", "../up", "a/b", ".hidden", "x" * 61, "a\nb", "nul\0"])
def test_names_lead_nowhere_else(tmp_path: Path, name: str) -> None:
    with pytest.raises(OdsError, match="preset"):
        save_preset(name, START, [tmp_path])
    assert list(tmp_path.iterdir()) == []


def test_a_name_too_long_is_reported_short(tmp_path: Path) -> None:
    with pytest.raises(OdsError, match=r"1 to 60 letters") as reported:
        save_preset("x" * 300, START, [tmp_path])
    assert len(str(reported.value)) < 150


def test_letters_of_all_languages_are_letters_and_a_name_is_kept_once(tmp_path: Path) -> None:
    save_preset("Größe 東", State(), [tmp_path])
    save_preset("Größe 東", START, [tmp_path])
    assert preset_names([tmp_path]) == ["Größe 東"]
    assert load_preset("Größe 東", State(), [tmp_path]) == START


def test_what_is_no_preset_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(OdsError, match="no such file"):
        load_preset("none", State(), [tmp_path])
    file = save_preset("bad", START, [tmp_path])
    file.write_bytes(b"\xff\x00" * 300_000)
    with pytest.raises(OdsError, match="link"):
        load_preset("bad", State(), [tmp_path])
    with pytest.raises(OdsError, match="no folder"):
        save_preset("a", START, [])
