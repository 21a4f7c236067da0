"""Files from anywhere: what is none is not waited for, and one without end is not read to it."""

import os
import socket
from pathlib import Path

import pytest

from ods.base.files.in_file import content_of, opened


@pytest.fixture
def short(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder whose sockets have short names."""
    monkeypatch.chdir(tmp_path)
    return Path()


@pytest.mark.parametrize("kind", ["pipe", "socket", "device"])
def test_what_is_no_file_is_refused_at_once(short: Path, kind: str) -> None:
    path = short / "x"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        socket.socket(socket.AF_UNIX).bind(str(path))
    else:
        path.symlink_to("/dev/zero")
    with pytest.raises(OSError, match=r"No such device|a device or a pipe, not a file"):
        content_of(path)


def test_a_folder_and_what_is_not_there_are_reported_as_always(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError):
        opened(tmp_path)
    with pytest.raises(FileNotFoundError):
        opened(tmp_path / "none")


def test_no_more_than_the_bound_is_read(tmp_path: Path) -> None:
    path = tmp_path / "long"
    path.touch()
    os.truncate(path, 10**12)  # takes no place on the disk
    with pytest.raises(OSError, match=r"larger than 4\.19 MB"):
        content_of(path)
    os.truncate(path, 1000)
    assert content_of(path, 1000) == bytes(1000)


def test_no_descriptor_is_left(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "x")
    before = len([*Path("/proc/self/fd").iterdir()])
    for path in (tmp_path, tmp_path / "x", Path("/dev/zero")):
        with pytest.raises(OSError, match=r"directory|device"):
            opened(path)
    assert len([*Path("/proc/self/fd").iterdir()]) == before
