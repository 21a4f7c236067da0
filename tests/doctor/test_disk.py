"""A map or recordings that could not be written are wrong before the processes start."""

import os
import pwd
import re
from pathlib import Path
from types import SimpleNamespace

import pytest

from ods.base.geodesy import SiteSettings
from ods.doctor.disk import map_file, recordings
from ods.recording.settings import RecordSettings
from ods.tracker.map.store import MapError, open_map

SITE = SiteSettings(latitude_deg=57.0, longitude_deg=9.9)


def test_a_map_that_is_there_and_one_to_be_made_are_good_and_not_touched(tmp_path: Path) -> None:
    there, new = tmp_path / "map.sqlite", tmp_path / "deep" / "new.sqlite"
    open_map(there, 57.0, 9.9).close()
    assert [item.level for path in (there, new) for item in map_file(path, SITE)] == ["good", "good"]
    assert sorted(tmp_path.iterdir()) == [there]


def test_no_map_at_all_is_noted() -> None:
    assert [item.level for item in map_file(None, SITE)] == ["note"]


def test_what_the_tracker_cannot_use_is_wrong(tmp_path: Path) -> None:
    plain, other = tmp_path / "plain", tmp_path / "other.sqlite"
    plain.write_text("no map")
    open_map(other, 10.0, 20.0).close()
    for path, said in (
        (plain / "map.sqlite", f"cannot be created: {plain} is not a folder"),
        (plain, "file is not a database"),
        (other, "its origin is 10.0, 20.0, not [site]"),
    ):
        (found,) = map_file(path, SITE)
        assert found.level == "wrong"
        assert found.text.startswith(said)


def test_a_file_and_a_folder_of_another_user_are_reported_with_their_owner(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = tmp_path / "map.sqlite"
    open_map(there, 57.0, 9.9).close()
    monkeypatch.setattr(os, "access", lambda *_: False)  # tests may run as root, who may do everything
    owner = tmp_path.owner()
    (file,), (folder,) = map_file(there, SITE), map_file(tmp_path / "deep" / "new.sqlite", SITE)
    assert (file.level, folder.level) == ("wrong", "wrong")
    me = pwd.getpwuid(os.geteuid()).pw_name
    reported = f"{there} may not be written by user {me}, as it belongs to {owner}: as root, `chown {me} {there}*`"
    assert file.text == reported
    with pytest.raises(MapError, match=re.escape(f"map {there}: {reported}")):  # what the tracker says
        open_map(there, 57.0, 9.9)
    assert folder.text.startswith(
        f"cannot be created: {tmp_path} may not be written by user {me}, as it belongs to {owner}"
    )


def test_a_read_only_disk_is_not_blamed_on_an_owner(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    there = tmp_path / "map.sqlite"
    open_map(there, 57.0, 9.9).close()
    monkeypatch.setattr(os, "access", lambda *_: False)
    monkeypatch.setattr(os, "statvfs", lambda _: SimpleNamespace(f_flag=os.ST_RDONLY))
    (file,), (folder,) = map_file(there, SITE), map_file(tmp_path / "new.sqlite", SITE)
    assert file.text == f"{there} is on a read-only disk"
    assert folder.text == f"cannot be created: {tmp_path} is on a read-only disk; see tracker.map.path"


def test_recordings_that_cannot_be_written_are_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "plain").touch()

    def found(folder: Path, keep_free_mb: float = 0.0, on: bool = True) -> list[tuple[str, str]]:
        settings = RecordSettings(on=on, folder=folder, keep_free_mb=keep_free_mb)
        return [(item.level, item.text) for item in recordings(settings)]

    assert found(tmp_path / "plain", on=False) == []
    ((level, text),) = found(tmp_path / "new" / "deep")
    assert level == "good"
    assert text.endswith(" GB are free")
    ((level, text),) = found(tmp_path, keep_free_mb=1e12)
    assert level == "wrong"
    assert text.endswith("MB are free, less than record.keep_free_mb, 1000000000000")
    no_folder = f"nothing can be recorded: {tmp_path / 'plain'} is not a folder; see record.folder"
    assert found(tmp_path / "plain") == [("wrong", no_folder)]
    monkeypatch.setattr(os, "access", lambda *_: False)
    ((level, text),) = found(tmp_path)
    assert (level, text.startswith(f"nothing can be recorded: {tmp_path} may not be written by user")) == (
        "wrong",
        True,
    )
