"""Data: scenes, files with and without times and poses, and what lies outside of the folders."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.messages import Ping
from ods.offline.source import scene_source
from ods.sim_sonar.scene.settings import SceneFile
from ods.sonar_link.files.ping_sequence import LazyPings
from ods.workbench.engine.data import KeptPings, open_data
from ods.workbench.model.state import DataReference
from tests.pipeline.pings import fan_bearings, make_ping
from tests.recordings import ARIS, DATA

SCENE = Path(__file__).parents[3] / "config" / "scenes" / "empty.toml"


def npz(folder: Path, *, timed: bool) -> Path:
    rng = np.random.default_rng(5)
    arrays: dict[str, Any] = {
        "frames": rng.integers(0, 255, (6, 8, 50), np.uint8),
        "bearing_rad": fan_bearings(8),
        "range0_m": np.float64(0.5),
        "dr_m": np.float64(0.1),
        "scale": np.str_("linear"),
    }
    if timed:
        arrays["t"] = np.array([100.0, 100.1, 100.2, 100.5, 100.6, 100.7])
    path = folder / "pings.npz"
    np.savez(path, **arrays)
    return path


def test_a_scene_gives_the_pings_that_ods_simulate_writes() -> None:
    data = open_data(DataReference(kind="scene"), load(SCENE, SceneFile), ())
    expected = scene_source(SCENE, "seabat6012")
    assert len(data.pings) == len(expected.pings)
    assert data.pings[2] == expected.pings[2]
    assert [pose.t_ns for pose in data.poses] == [pose.t_ns for pose in expected.poses]
    assert data.truth(2) == expected.truths[2]
    assert data.period_s == pytest.approx(data.t_s(1), abs=1e-6)


@pytest.mark.parametrize("timed", [True, False])
def test_a_file_of_pings_without_poses_serves(tmp_path: Path, timed: bool) -> None:
    data = open_data(DataReference(kind="file", path=str(npz(tmp_path, timed=timed))), None, [tmp_path])
    assert len(data.pings) == 6
    assert not data.poses
    assert data.timed == timed
    assert data.period_s == (pytest.approx(0.1) if timed else None)
    assert data.t_s(3) == (pytest.approx(0.5) if timed else 3.0)
    assert data.truth(0) is None


def test_a_real_recording_opens() -> None:
    data = open_data(DataReference(kind="file", path=str(ARIS)), None, [DATA])
    assert data.pings[0].beams > 40


def test_files_outside_of_the_folders_are_refused_and_links_are_followed(tmp_path: Path) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    outside = npz(tmp_path, timed=True)
    link = inside / "pings.npz"
    link.symlink_to(outside)
    for path in (outside, link, inside / ".." / "pings.npz", Path("/etc/passwd"), Path("a\0b")):
        with pytest.raises(OdsError) as refused:
            open_data(DataReference(kind="file", path=str(path)), None, [inside])
        assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("reference", "complaint"),
    [
        (DataReference(), "no data"),
        (DataReference(kind="scene"), "scene: none is open"),
        (DataReference(kind="file", path="nothing.npz"), "nothing.npz"),
        (DataReference(kind="file", path="bad.npz"), "bad.npz"),
        (DataReference(kind="live", path="run"), "live"),
    ],
)
def test_what_cannot_be_opened_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reference: DataReference, complaint: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.npz").write_bytes(b"PK\3\4 and no more")
    with pytest.raises(OdsError, match=complaint) as refused:
        open_data(reference, None, [tmp_path])
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("sonar", ["../sonars/seabat6012", "/etc/sonar.toml", "unheard-of"])
def test_sonars_are_named_or_lie_in_the_folders(tmp_path: Path, sonar: str) -> None:
    with pytest.raises(OdsError):
        open_data(DataReference(kind="scene", sonar=sonar), load(SCENE, SceneFile), [tmp_path])


def test_the_last_pings_are_kept_and_no_more_than_fit() -> None:
    made: list[int] = []

    def make(place: int) -> Ping:
        made.append(place)
        return make_ping(np.zeros((4, 25), np.uint8), seq=place)

    pings: Sequence[Ping] = KeptPings(LazyPings(10, make), most_bytes=300)
    assert [ping.seq for ping in pings[2:5]] == [2, 3, 4]
    assert pings[-1].seq == 9
    assert made == [2, 3, 4, 9]
    assert [pings[place].seq for place in (9, 4, 3, 2)] == [9, 4, 3, 2]
    assert made == [2, 3, 4, 9, 2]
    with pytest.raises(IndexError):
        pings[10]
