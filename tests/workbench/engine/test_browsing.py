"""A folder is listed as far as it may be read; files that were opened last come back, the newest first."""

import os
from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.workbench.engine.files import browsing


def test_folders_and_known_files_are_listed_and_nothing_that_leads_elsewhere(tmp_path: Path) -> None:
    inside = tmp_path / "in"
    for folder in ("b", "A", ".git"):
        (inside / folder).mkdir(parents=True)
    for file in ("y.mcap", "X.NPZ", "notes.txt", ".hidden.npz"):
        (inside / file).write_bytes(b"12")
    (tmp_path / "out.npz").touch()
    (inside / "link.npz").symlink_to(tmp_path / "out.npz")
    (inside / "dangling.npz").symlink_to("none")
    (inside / "up").symlink_to(tmp_path)
    os.mkfifo(inside / "pipe.npz")
    listed = browsing.listing(inside, [inside])
    assert [(each.name, each.is_folder, each.size) for each in listed.entries] == [
        ("A", True, 0), ("b", True, 0), ("X.NPZ", False, 2), ("y.mcap", False, 2),
    ]  # fmt: skip
    assert (listed.is_cut, listed.is_recording) == (False, True)
    for elsewhere in (tmp_path, inside / "up", inside / "none", inside / "y.mcap", Path("/")):
        with pytest.raises(OdsError):
            browsing.listing(elsewhere, [inside])


def test_a_folder_of_very_many_is_cut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(browsing, "MOST_LISTED", 3)
    for number in range(5):
        (tmp_path / f"{number}.npz").touch()
    listed = browsing.listing(tmp_path, [tmp_path])
    assert (len(listed.entries), listed.is_cut) == (3, True)


def test_files_opened_last_come_first_and_what_is_gone_or_elsewhere_does_not_come(
    tmp_path: Path, own_data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(browsing, "MOST_RECENT", 3)
    assert browsing.recent([tmp_path]) == []
    for name in ("a.npz", "b.npz", "c.npz", "d.npz", "b.npz"):
        (tmp_path / name).touch()
        browsing.note(str(tmp_path / name))
    assert [each.path.name for each in browsing.recent([tmp_path])] == ["b.npz", "d.npz", "c.npz"]
    (tmp_path / "d.npz").unlink()
    browsing.note("/etc/hostname")
    assert [each.path.name for each in browsing.recent([tmp_path])] == ["b.npz"]
    for broken in (b"{", b"[1]", b"\xff"):
        (own_data / "recent.json").write_bytes(broken)
        assert browsing.recent([tmp_path]) == []
