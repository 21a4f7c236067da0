import os
from pathlib import Path

import numpy as np
import pytest

from ods import cli
from ods.base.errors import OdsError
from ods.base.files.out_file import opened_to_seek, refuse_unwritable, written_whole


def why_refused(path: Path) -> str:
    with pytest.raises(OdsError) as raised:
        refuse_unwritable(None, path)
    return str(raised.value).removeprefix(f"{path}: ")


def test_what_cannot_be_written_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "file"
    file.write_text("x")
    assert why_refused(tmp_path) == "is a folder"
    assert why_refused(file / "x.png") == f"no such folder: {file}"
    assert why_refused(tmp_path / "absent" / "x.png") == f"no such folder: {tmp_path / 'absent'}"
    assert why_refused(tmp_path / ("x" * 300)) == "file name too long"
    refuse_unwritable(file, tmp_path / "new", None, Path(os.devnull))
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    assert why_refused(tmp_path / "new") == f"no permission to write {tmp_path}, or its disk is read-only"
    assert why_refused(file) == f"no permission to write {file}, or its disk is read-only"


@pytest.mark.parametrize(
    "arguments",
    [
        ("detect", "unread.npz", "--out"),
        ("detect", "unread.npz", "--plot"),
        ("detect", "unread.npz", "--sheet"),
        ("simulate", "unread.toml", "--out"),
        ("assess", "detect", "--out"),
        ("assess", "sea", "--out"),
        ("assess", "track", "--out"),
        ("assess", "track", "--figures"),
    ],
    ids=" ".join,
)
def test_it_is_said_before_the_work(
    arguments: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "folder.png"
    out.mkdir()
    for name in ("unread.npz", "unread.toml"):
        (tmp_path / name).write_text("nothing that could be read")
    words = [str(tmp_path / word) if word.startswith("unread") else word for word in arguments]
    assert cli.main([*words, str(out)]) == 2
    assert capsys.readouterr().err == f"ods {arguments[0]}: {out}: is a folder\n"


def test_no_result_goes_over_what_is_read_or_over_another_result(tmp_path: Path) -> None:
    recording, link, picture = tmp_path / "pings.npz", tmp_path / "link.npz", tmp_path / "new.png"
    recording.write_text("x")
    link.symlink_to(recording)
    for out in (recording, link, tmp_path / "." / ".." / tmp_path.name / "pings.npz"):
        with pytest.raises(OdsError, match="is an input, and is not overwritten"):
            refuse_unwritable(out, read=(None, recording))
    with pytest.raises(OdsError, match="two results cannot be written to one file"):
        refuse_unwritable(picture, None, picture)
    refuse_unwritable(picture, Path(os.devnull), Path(os.devnull), read=(recording, Path(os.devnull)))


@pytest.mark.parametrize("command", ["detect", "track"])
@pytest.mark.parametrize("option", ["--out", "--plot"])
def test_a_recording_is_not_overwritten(
    command: str, option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording = tmp_path / "pings.npz"
    recording.write_bytes(b"precious")
    assert cli.main([command, str(recording), option, str(recording)]) == 2
    assert capsys.readouterr().err == f"ods {command}: {recording}: is an input, and is not overwritten\n"
    assert recording.read_bytes() == b"precious"


def test_what_is_written_whole_takes_the_place_of_what_was_there(tmp_path: Path) -> None:
    out = tmp_path / "out.npz"
    out.write_text("old")
    with written_whole(out) as part:
        part.write_text("new")
        assert out.read_text() == "old"
    assert out.read_text() == "new"
    assert list(tmp_path.iterdir()) == [out]


def test_a_device_is_not_replaced(tmp_path: Path) -> None:
    link = tmp_path / "out.npz"
    link.symlink_to("/dev/null")
    with written_whole(link) as part:
        assert part == Path("/dev/null")
    assert list(tmp_path.iterdir()) == [link]


def test_a_device_gets_what_is_written_to_and_fro(tmp_path: Path) -> None:
    for path in (Path("/dev/null"), tmp_path / "out.npz"):
        with opened_to_seek(path) as file:
            np.savez_compressed(file, a=np.arange(3))
    assert np.load(tmp_path / "out.npz")["a"].tolist() == [0, 1, 2]
