"""Files that mean no good: each is one line of OdsError, whatever is in it, and what lies elsewhere is not opened."""

import io
import os
import random
import zipfile
from pathlib import Path

import numpy as np
import pytest

from ods.base.errors import OdsError
from ods.base.files.shipped import shipped_file
from ods.offline.mission import MissionSettings
from ods.workbench.engine.data import open_data
from ods.workbench.engine.files.openable import opening
from ods.workbench.engine.ping.analysis import PingAnalyzer
from ods.workbench.model.apply import apply
from ods.workbench.model.state import State

DATA = Path(__file__).parents[2] / "data"
REAL = (DATA / "aris" / "sample.aris", DATA / "oculus" / "three_pings_8bit.raw", DATA / "replay" / "figure11.mcap")
SCENES = {
    "not a number": ("seed = 11", "seed = nan"),
    "a long number": ("seed = 11", f"seed = {'9' * 5000}"),
    "brackets": ("seed = 11", f"seed = {'[' * 20_000}"),
    "another type": ("radius_m = 1.5", "radius_m = 'x'"),
    "for ever": ("duration_s = 60.0", "duration_s = inf"),
    "nearly for ever": ("duration_s = 60.0", "duration_s = 1e300"),
    "louder than any amplitude": ("gain = 20000.0", "gain = 1e300"),
    "loud where it is squared": ("gain = 20000.0", "gain = 1e25"),
    "a loud sonar besides": (
        "[image]",
        "[image]\ninterference = [{ position_ned = [20.0, 0.0, 5.0], level_counts = 1e300 }]",
    ),
    "a bright arc": ("[image]", "[image]\ndrop_ins = [{ range_m = 20.0, gain_db = 1e5 }]"),
    "an unknown key": ("seed = 11", "seed = 11\nplugins = ['evil.py']"),
    "too large": ("seed = 11", "seed = 11\n" + "# comment\n" * 500_000),
}


def look_at(file: Path, folder: Path) -> None:
    """Open a file and look at its first ping, as the page does. Raises OdsError."""
    state = apply(State(), opening(file, [folder]))
    data = open_data(state.data, state.scene, [folder])
    PingAnalyzer(data).analyze(MissionSettings(), 0)


def refused(file: Path, folder: Path) -> str:
    """Return what is said of a file that cannot be opened."""
    with pytest.raises(OdsError) as refusal:
        look_at(file, folder)
    text = str(refusal.value)
    assert "\n" not in text
    assert len(text) < 500
    return text


@pytest.mark.parametrize("change", SCENES.values(), ids=SCENES)
def test_scenes(tmp_path: Path, change: tuple[str, str]) -> None:
    text = shipped_file("scenes/figure11.toml").read_text()
    assert change[0] in text
    file = tmp_path / "scene.toml"
    file.write_text(text.replace(*change))
    said = refused(file, tmp_path)
    assert "scene" in said
    assert ("higher than the largest amplitude" in said) == any(word in change[1] for word in ("gain", "level_counts"))


@pytest.mark.parametrize("suffix", [".npz", ".s7k", ".aris", ".raw", ".avi", ".mcap", ".toml"])
@pytest.mark.parametrize("content", [b"", b"\0" * 4096, b"\xff" * 3000, random.Random(1).randbytes(5000)])
def test_files_of_anything(tmp_path: Path, suffix: str, content: bytes) -> None:
    file = tmp_path / f"file{suffix}"
    file.write_bytes(content)
    refused(file, tmp_path)


@pytest.mark.parametrize("real", REAL, ids=lambda path: path.suffix)
def test_recordings_with_bytes_changed_are_read_or_refused(tmp_path: Path, real: Path) -> None:
    chance, content = random.Random(7), real.read_bytes()
    for number in range(8):
        changed = bytearray(content[: chance.choice([200, len(content) // 2, len(content)])])
        for _ in range(chance.choice([1, 20])):
            changed[chance.randrange(min(len(changed), 1024))] = chance.randrange(256)
        file = tmp_path / f"{number}{real.suffix}"
        file.write_bytes(changed)
        said = ""
        try:
            look_at(file, tmp_path)
        except OdsError as error:
            said = str(error)
        assert "\n" not in said


def test_a_small_file_that_says_it_is_huge(tmp_path: Path) -> None:
    """An archive of which one array claims 8 TB, and unpacks to nothing."""
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000, 1000000), }"
    header += b" " * (64 - (len(header) + 11) % 64) + b"\n"
    one = io.BytesIO()
    np.save(one, np.zeros(3))
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("bearing_rad", "range0_m", "dr_m", "scale", "sound_speed", "frequency_hz", "t"):
            archive.writestr(f"{name}.npy", one.getvalue())
        archive.writestr("frames.npy", b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    refused(tmp_path / "bomb.npz", tmp_path)


def test_what_is_no_file_or_lies_elsewhere(tmp_path: Path) -> None:
    inside = tmp_path / "in"
    inside.mkdir()
    (tmp_path / "out.npz").write_bytes(b"")
    (inside / "link.npz").symlink_to(tmp_path / "out.npz")
    (inside / "folder").symlink_to(tmp_path)
    (inside / "loop.npz").symlink_to(inside / "loop.npz")
    (inside / "endless.npz").symlink_to("/dev/zero")
    os.mkfifo(inside / "pipe.npz")
    os.mkfifo(inside / "pipe.toml")
    for name in ("link.npz", "folder/out.npz", "../out.npz", "endless.npz"):
        assert "not under the workbench's folders" in refused(inside / name, inside)
    for name in ("pipe.npz", "pipe.toml"):
        assert "neither a file nor a folder" in refused(inside / name, inside)
    refused(inside / "loop.npz", inside)
    refused(inside / "none.npz", inside)
