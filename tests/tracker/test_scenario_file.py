"""`ods track`'s files: what is written, and one clear line for each way in which a file can be wrong."""

import contextlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ods.tracker.scenario import ScenarioError, load_scenario, track_file
from ods.tracker.settings import TrackerSettings

SCANS = 70


def arrays() -> dict[str, Any]:
    """Ten seconds of one object at (40, 5), with a pose that turns, and one useless detection."""
    rng = np.random.default_rng(0)
    t = np.arange(SCANS) / 7.0
    yaw = 0.02 * t
    distance, azimuth = np.hypot(40.0, 5.0), np.arctan2(5.0, 40.0)
    det = np.column_stack(
        [
            np.arange(SCANS),
            distance + rng.normal(0.0, 0.1, SCANS),
            azimuth - yaw + rng.normal(0.0, 0.0087, SCANS),
            np.full(SCANS, 1.5),
            np.full(SCANS, 200.0),
        ]
    )
    det[3, 1] = np.nan
    return {
        "t": t,
        "auv_pos": np.zeros((SCANS, 3)),
        "auv_rpy": np.column_stack([0 * t, 0 * t, yaw]),
        "det": rng.permutation(det),
        "truth": np.zeros((SCANS, 1, 7)),
        "meta": json.dumps({"range_max": 100.0, "half_fov": 0.785, "half_vert": 0.17, "pd": 0.9, "clutter_lambda": 0}),
    }


def test_tracks_are_written_as_documented(tmp_path: Path) -> None:
    np.savez(tmp_path / "in.npz", **arrays())
    line = track_file(tmp_path / "in.npz", tmp_path / "out.npz", TrackerSettings())
    assert line.startswith("70 scans, 70 detections, 1 objects")
    with np.load(tmp_path / "out.npz") as out:
        trk, wall_ms = out["trk"], out["wall_ms"]
    assert wall_ms.shape == (SCANS,)
    assert (wall_ms > 0.0).all()
    assert trk.shape == (SCANS - 2, 8) or trk.shape == (SCANS - 3, 8)  # from the third echo on, one row a scan
    last = trk[-1]
    assert last[0] == SCANS - 1
    assert (last[1], last[7]) == (1, 1)
    np.testing.assert_allclose(last[2:4], [40.0, 5.0], atol=0.2)
    np.testing.assert_allclose(last[4:6], 0.0, atol=0.05)
    assert last[6] == pytest.approx(1.5, abs=0.1)


def test_meta_and_its_keys_may_be_missing(tmp_path: Path) -> None:
    content = arrays()
    del content["meta"], content["truth"]
    np.savez(tmp_path / "in.npz", **content)
    assert load_scenario(tmp_path / "in.npz").meta.range_max == 100.0


def test_no_detections_and_no_scans(tmp_path: Path) -> None:
    content = arrays() | {"det": np.zeros((0, 5))}
    np.savez(tmp_path / "in.npz", **content)
    track_file(tmp_path / "in.npz", tmp_path / "out.npz", TrackerSettings())
    with np.load(tmp_path / "out.npz") as out:
        assert out["trk"].shape == (0, 8)
    none = np.zeros((0, 3))
    np.savez(tmp_path / "empty.npz", t=np.zeros(0), auv_pos=none, auv_rpy=none, det=np.zeros((0, 5)))
    assert track_file(tmp_path / "empty.npz", tmp_path / "out.npz", TrackerSettings()).startswith("0 scans")


def test_a_pose_that_is_not_a_number_is_no_pose(tmp_path: Path) -> None:
    content = arrays()
    content["auv_pos"][30:35] = np.nan
    np.savez(tmp_path / "in.npz", **content)
    track_file(tmp_path / "in.npz", tmp_path / "out.npz", TrackerSettings())
    with np.load(tmp_path / "out.npz") as out:
        assert np.isfinite(out["trk"]).all()
        assert set(out["trk"][:, 1]) == {1}


def replace(name: str, value: Any) -> Callable[[dict[str, Any]], dict[str, Any]]:
    return lambda content: content | {name: value}


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda content: {k: v for k, v in content.items() if k != "det"}, "array det is missing"),
        (replace("t", np.zeros((3, 2))), "t: expected shape"),
        (replace("t", np.arange(SCANS)[::-1]), "t: times"),
        (replace("t", np.full(SCANS, np.nan)), "t: times"),
        (replace("t", np.array(["noon"] * SCANS)), "t: expected numbers"),
        (replace("auv_rpy", np.zeros((3, 3))), "auv_rpy: expected shape"),
        (replace("auv_pos", np.full((SCANS, 3), 1e300)), "auv_pos: a number is larger"),
        (replace("auv_rpy", np.full((SCANS, 3), -np.inf)), "auv_rpy: a number is larger"),
        (replace("meta", '{"pose_sigma_xy": 1e300}'), "pose_sigma_xy: a number is larger"),
        (replace("det", np.zeros((3, 4))), "det: expected shape"),
        (replace("det", np.full((3, 5), 1e6)), "det: scan indices"),
        (replace("det", np.full((3, 5), 0.5)), "det: scan indices"),
        (replace("meta", "{"), "meta:"),
        (replace("meta", '{"range_max": -5}'), "meta:"),
        (replace("meta", '{"pd": "high"}'), "meta:"),
        (replace("t", np.array([None] * SCANS)), "Python objects"),
    ],
)
def test_one_line_for_each_mistake(
    tmp_path: Path, change: Callable[[dict[str, Any]], dict[str, Any]], text: str
) -> None:
    np.savez(tmp_path / "in.npz", **change(arrays()))
    with pytest.raises(ScenarioError, match=text) as error:
        load_scenario(tmp_path / "in.npz")
    assert "\n" not in str(error.value)
    assert "in.npz" in str(error.value)


def test_files_that_are_no_scenario(tmp_path: Path) -> None:
    np.savez(tmp_path / "good.npz", **arrays())
    good = (tmp_path / "good.npz").read_bytes()
    rng = np.random.default_rng(0)
    for content in (b"", b"not a zip", good[:100], good[: len(good) // 2], bytes(len(good)), rng.bytes(2000)):
        (tmp_path / "bad.npz").write_bytes(content)
        with pytest.raises(ScenarioError):
            load_scenario(tmp_path / "bad.npz")
    np.save(tmp_path / "single.npy", np.zeros(3))
    for path in (tmp_path / "absent.npz", tmp_path, tmp_path / "single.npy"):
        with pytest.raises(ScenarioError):
            load_scenario(path)
    with pytest.raises(ScenarioError, match="No such file"):
        track_file(tmp_path / "good.npz", tmp_path / "absent" / "out.npz", TrackerSettings())


def test_damaged_bytes_anywhere_end_in_a_line_or_in_tracks(tmp_path: Path) -> None:
    np.savez_compressed(tmp_path / "good.npz", **arrays())
    good = bytearray((tmp_path / "good.npz").read_bytes())
    rng = np.random.default_rng(1)
    for _ in range(150):
        damaged = good.copy()
        for place in rng.integers(0, len(good), 3):
            damaged[place] = rng.integers(256)
        (tmp_path / "bad.npz").write_bytes(damaged)
        with contextlib.suppress(ScenarioError):
            load_scenario(tmp_path / "bad.npz")
