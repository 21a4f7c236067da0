"""Arrays from files that may lie about their size."""

import contextlib
import io
import os
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.base.files.npz_file import load_npz


def saved(path: Path, **arrays: object) -> Path:
    np.savez_compressed(path, **arrays)  # type: ignore[arg-type]
    return path


def test_arrays_come_back_all_or_by_name(tmp_path: Path) -> None:
    path = saved(tmp_path / "a.npz", x=np.arange(3), y=np.array("text"))
    assert sorted(load_npz(path)) == ["x", "y"]
    (only,) = load_npz(path, ["x", "z"]).items()
    assert only[0] == "x"
    assert only[1].tolist() == [0, 1, 2]


def test_what_unpacks_to_more_than_the_bound_is_refused_before_it_is_unpacked(tmp_path: Path) -> None:
    path = saved(tmp_path / "a.npz", x=np.zeros(8_000_000, np.uint8))
    assert path.stat().st_size < 20_000
    tracemalloc.start()
    with pytest.raises(ValueError, match="unpacks to 8 MB, more than 1 MB"):
        load_npz(path, most_bytes=1_000_000)
    assert tracemalloc.get_traced_memory()[1] < 1_000_000
    tracemalloc.stop()
    assert load_npz(path)["x"].size == 8_000_000


def test_a_head_that_tells_of_more_than_there_is_reserves_nothing(tmp_path: Path) -> None:
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("x.npy", head.getvalue() + bytes(800))
    with pytest.raises(ValueError, match=r"x\.npy tells of more than it holds"):
        load_npz(tmp_path / "a.npz")


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.npz")
    with pytest.raises(OSError, match="no file, but"):
        load_npz(tmp_path / "a.npz")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = saved(tmp_path_factory.mktemp("npz") / "a.npz", x=np.arange(50.0), y=np.array("text"))
    return path.read_bytes()


@given(st.data())
def test_flipped_and_cut_files_are_read_or_refused_in_a_line(whole: bytes, data: st.DataObject) -> None:
    damaged = bytearray(whole[: data.draw(st.integers(0, len(whole)))])
    for place in data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=4)):
        if place < len(damaged):
            damaged[place] ^= data.draw(st.integers(1, 255))
    path = Path(os.environ.get("TMPDIR", "/tmp")) / f"ods-npz-{os.getpid()}.npz"
    path.write_bytes(damaged)
    with contextlib.suppress(ValueError):  # the only one that it may raise
        load_npz(path)
    path.unlink()


@pytest.mark.parametrize("zip64", [False, True])
def test_a_list_of_very_many_arrays_is_not_read(tmp_path: Path, zip64: bool) -> None:
    path = tmp_path / "a.npz"
    with zipfile.ZipFile(path, "w") as archive:
        for number in range(70_000 if zip64 else 20_000):  # of more than 65,535 zip64 tells
            archive.writestr(f"{number}.npy", b"")
    tracemalloc.start()
    with pytest.raises(ValueError, match="holds very many arrays"):
        load_npz(path, ["x"])
    assert tracemalloc.get_traced_memory()[1] < 1_000_000
    tracemalloc.stop()
