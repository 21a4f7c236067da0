"""A map of obstacles that the tracker could not write is wrong before it starts."""

import os
import pwd
import re
from pathlib import Path

import pytest

from ods.base.geodesy import SiteSettings
from ods.doctor.map_file import examine
from ods.tracker.map.store import MapError, open_map

SITE = SiteSettings(latitude_deg=57.0, longitude_deg=9.9)


def test_a_map_that_is_there_and_one_to_be_made_are_good_and_not_touched(tmp_path: Path) -> None:
    there, new = tmp_path / "map.sqlite", tmp_path / "deep" / "new.sqlite"
    open_map(there, 57.0, 9.9).close()
    assert [item.level for path in (there, new) for item in examine(path, SITE)] == ["good", "good"]
    assert sorted(tmp_path.iterdir()) == [there]


def test_no_map_at_all_is_noted() -> None:
    assert [item.level for item in examine(None, SITE)] == ["note"]


def test_what_the_tracker_cannot_use_is_wrong(tmp_path: Path) -> None:
    plain, other = tmp_path / "plain", tmp_path / "other.sqlite"
    plain.write_text("no map")
    open_map(other, 10.0, 20.0).close()
    for path, said in (
        (plain / "map.sqlite", f"cannot be created: {plain} is not a folder"),
        (plain, "file is not a database"),
        (other, "its origin is 10.0, 20.0, not [site]"),
    ):
        (found,) = examine(path, SITE)
        assert found.level == "wrong"
        assert found.text.startswith(said)


def test_a_file_and_a_folder_of_another_user_are_reported_with_their_owner(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = tmp_path / "map.sqlite"
    open_map(there, 57.0, 9.9).close()
    monkeypatch.setattr(os, "access", lambda *_: False)  # tests may run as root, who may do everything
    owner = tmp_path.owner()
    (file,), (folder,) = examine(there, SITE), examine(tmp_path / "deep" / "new.sqlite", SITE)
    assert (file.level, folder.level) == ("wrong", "wrong")
    me = pwd.getpwuid(os.geteuid()).pw_name
    reported = f"{there} may not be written by user {me}, as it belongs to {owner}: as root, `chown {me} {there}*`"
    assert file.text == reported
    with pytest.raises(MapError, match=re.escape(f"map {there}: {reported}")):  # what the tracker says
        open_map(there, 57.0, 9.9)
    assert folder.text.startswith(f"cannot be created: {tmp_path} belongs to {owner}, and is not writable")
