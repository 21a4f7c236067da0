"""Which decoder a file gets: by what it holds, in doubt by its suffix; and what no decoder can read."""

import importlib
import inspect
import os
import pkgutil
import shutil
from pathlib import Path

import pytest

from ods.sonar_link import files
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.opening import DECODERS, PingFileError, open_pings
from ods.tracker.scenario import is_scenario
from tests.recordings import ARIS, OCULUS


def test_every_decoder_is_registered() -> None:
    for module in pkgutil.walk_packages(files.__path__, f"{files.__name__}."):
        importlib.import_module(module.name)
    kinds = {*Decoder.__subclasses__(), *(own for kind in Decoder.__subclasses__() for own in kind.__subclasses__())}
    assert {type(decoder) for decoder in DECODERS} == {kind for kind in kinds if not inspect.isabstract(kind)}
    assert all(decoder.signature for decoder in DECODERS)


@pytest.mark.parametrize(("recording", "pings"), [(ARIS, 6), (OCULUS, 3)])
@pytest.mark.parametrize("suffix", [".s7k", ""])
def test_the_content_decides_not_the_suffix(tmp_path: Path, recording: Path, pings: int, suffix: str) -> None:
    assert len(open_pings(Path(shutil.copy(recording, tmp_path / f"renamed{suffix}"))).pings) == pings


@pytest.mark.parametrize("suffix", [".npz", ".ARIS", ".bin"])
@pytest.mark.parametrize(
    ("start", "message"),
    [
        (b"PK\x03\x04\xff\xff\x00\x00", "not a complete .npz file"),
        (b"DDF\x05\xff\xff\x00\x00", "not an ARIS recording"),  # of 65535 frames
        (b"SO\x00\x00\xff\xff\x00\x00", "no complete simple ping result"),
        (b"RIFF\xff\xff\x00\x00AVI ", "needs its fan geometry"),  # of 65535 bytes
        (b"\x05\x00<\x00\xff\xff\x00\x00", "no ping in it"),
    ],
)
def test_a_sync_word_of_s7k_within_another_format_s_beginning(
    tmp_path: Path, start: bytes, message: str, suffix: str
) -> None:
    path = tmp_path / f"start{suffix}"
    path.write_bytes(start + bytes(100))
    with pytest.raises(PingFileError, match=message):
        open_pings(path)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.npz", None, "No such file"),
        ("empty.npz", b"", "the file is empty"),
        ("cut.npz", b"PK\x03\x04 and then nothing", "not a complete .npz file"),
        ("text.npz", b"not a zip archive at all", "not a complete .npz file"),
        ("text.s7k", b"not a recording at all", "no ping in it"),
        ("text.aris", b"not a recording at all", "not an ARIS recording"),
        ("text.raw", b"not a recording at all", "no complete simple ping result"),
        ("clip.avi", b"RIFF and so on", "not one of the known formats"),
    ],
)
def test_any_other_file_is_one_clear_line(tmp_path: Path, name: str, content: bytes | None, message: str) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(PingFileError, match=message) as caught:
        open_pings(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_a_folder_is_no_recording(tmp_path: Path) -> None:
    with pytest.raises(PingFileError, match="Is a directory"):
        open_pings(tmp_path)


@pytest.mark.timeout(30)
@pytest.mark.parametrize("suffix", [".npz", ".s7k"])
def test_a_pipe_that_nobody_writes_to_is_not_waited_for(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"pipe{suffix}"
    os.mkfifo(path)
    assert not is_scenario(path)
    with pytest.raises(PingFileError, match="a device or a pipe, not a file"):
        open_pings(path)
