"""Pictures and movies: right format, in the right folder, with the configuration's hash."""

from pathlib import Path

import pytest
from PIL import Image

from ods.base.errors import OdsError
from ods.base.files.shipped import shipped_file
from ods.offline.source import scene_source
from ods.workbench.engine.data import Data
from ods.workbench.engine.files.prints import config_hash
from ods.workbench.engine.printing import print_ping, record_movie
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.state import DataReference, State
from tests.workbench.model.test_history import LAST

SOURCE = scene_source(shipped_file("scenes/figure11.toml"), "seabat6012")
STARTS = {".png": b"\x89PNG", ".pdf": b"%PDF", ".svg": b"<?xml"}


@pytest.mark.parametrize("ending", list(STARTS))
def test_each_format_is_what_it_says(tmp_path: Path, ending: str) -> None:
    tuning = State().tuning
    file = print_ping(SOURCE.pings[3], tuning, tmp_path / f"p{ending}", [tmp_path], name="figure 11", style="light")
    assert file.read_bytes().startswith(STARTS[ending])
    caption = f"figure 11, ping 3: 3 detections; configuration {config_hash(tuning)}"
    if ending == ".png":
        with Image.open(file) as picture:
            assert picture.info["Title"] == caption
    elif ending == ".pdf":
        assert f"/Title ({caption})".encode() in file.read_bytes()
    else:
        assert f"<dc:title>{caption}</dc:title>" in file.read_text()
    if ending == ".svg":
        assert file.read_text().count("<!-- figure 11, ping 3: ") == 1
        assert f"configuration {config_hash(tuning)} -->" in file.read_text()


def test_the_hash_is_of_what_runs() -> None:
    state = State()
    changed = apply(state, do.SetSetting(f"pipeline.stage[{LAST}].high", 9.0))
    assert config_hash(changed.tuning) != config_hash(state.tuning)
    assert config_hash(apply(changed, do.SetView("palette", "gray")).tuning) == config_hash(changed.tuning)
    assert config_hash(apply(state, do.BypassStage(0, True)).tuning) != config_hash(state.tuning)


def test_a_movie_ends_where_it_is_stopped(tmp_path: Path) -> None:
    file = record_movie(
        Data(DataReference(), SOURCE.pings, SOURCE.poses), State().tuning, tmp_path / "m.webp", [tmp_path],
        progress=lambda share: share * len(SOURCE.pings) < 3.0, style="dark",
    )  # fmt: skip
    with Image.open(file) as movie:
        assert movie.format == "WEBP"
        assert 1 <= getattr(movie, "n_frames", 1) <= 3


@pytest.mark.parametrize("name", ["../p.png", "p.exe", "p", "no/p.png"])
def test_nothing_is_written_elsewhere(tmp_path: Path, name: str) -> None:
    (tmp_path / "in").mkdir()
    with pytest.raises(OdsError):
        print_ping(SOURCE.pings[0], State().tuning, tmp_path / "in" / name, [tmp_path / "in"], name="x", style="dark")
    assert sum(path.is_file() for path in tmp_path.rglob("*")) == 0
