"""`ods track` on pings: any way to the same lists, results that agree with each other, one line for what is no use."""

import json
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from PIL import Image

from ods.base.geodesy import LocalFrame
from ods.cli import main
from ods.messages import Ping
from ods.offline.mission import Mission, MissionSettings
from ods.offline.poses import pose_track_of
from ods.offline.source import open_source
from ods.recording.mcap.segment import Logged, Segment
from ods.sonar_link.files.opening import open_pings
from ods.sonar_link.files.s7k.pose import GeodeticPose, encode_pose
from ods.sonar_link.files.s7k.writer import write_s7k

UTC_NS = 1_700_000_000_000_000_000
SONAR = """
name = "small"
frequency_hz = 455000.0
sound_speed = 1500.0
beams_per_plane = 30
beam_spacing_deg = 3.0
beam_width_deg = 3.0
side_lobe_db = -25.0
half_vertical_deg = 10.0
range0_m = 0.2
dr_m = 0.2
samples = 300
overhead_s = 0.016
"""
SCENE = """
seed = 5
duration_s = 4.0
shadows = false
[vehicle]
position_ned = [3.0, -2.0, 20.0]
velocity_ned = [1.0, 0.2, 0.0]
yaw = { amplitude_deg = 5.0, period_s = 6.0 }
[[objects]]
shape = "sphere"
name = "ball"
position_ned = [40.0, 5.0, 20.0]
radius_m = 1.5
surface = { cd = 0.1, cs = 0.05, sigma_deg = 15.0 }
[image]
gain = 20000.0
noise_counts = 30.0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A scene, its sonar, and what `ods simulate` makes of them."""
    folder = tmp_path_factory.mktemp("track")
    (folder / "small.toml").write_text(SONAR)
    (folder / "scene.toml").write_text(SCENE)
    sonar = ["--sonar", str(folder / "small.toml")]
    assert main(["simulate", str(folder / "scene.toml"), *sonar, "--out", str(folder / "pings.npz")]) == 0
    _record(folder)
    return folder


def _record(folder: Path) -> None:
    """The pings and poses of the .npz as `ods record` has them, of the bus."""
    recording = open_pings(folder / "pings.npz")
    (folder / "recorded").mkdir()
    segment = Segment(folder / "recorded" / "0.mcap", 0, {"ods": {"utc_offset_ns": "0"}})
    segment.enclose("config.toml", "text/plain", b"[site]\nlatitude_deg = -10.0\nlongitude_deg = 20.0\n", 0)
    for pose in pose_track_of(folder / "pings.npz", recording).poses:
        segment.write([Logged("pose", pose.t_ns, msgspec.msgpack.encode(pose))])
    for ping in recording.pings:
        segment.write([Logged("ping", ping.t_ns, msgspec.msgpack.encode(ping))])
    segment.finish()


def _lists(capsys: pytest.CaptureFixture[str], *arguments: object) -> list[dict[str, Any]]:
    assert main(["track", "--json", *map(str, arguments)]) == 0
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def _places(lists: list[dict[str, Any]]) -> list[list[list[float]]]:
    return [[[o["id"], *np.round(o["position_ned"], 6)] for o in reported["obstacles"]] for reported in lists]


def test_scene_file_and_recording_give_the_same_lists(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    by_file = _lists(capsys, folder / "pings.npz")
    assert _lists(capsys, folder / "recorded") == by_file
    assert _lists(capsys, folder / "recorded" / "0.mcap") == by_file
    by_scene = _lists(capsys, folder / "scene.toml", "--sonar", folder / "small.toml")
    assert _places(by_file) == _places(by_scene)
    assert _places(by_file)[-1][0][1:3] == pytest.approx([40.0, 5.0], abs=1.0)


def test_all_results_tell_the_same(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, plot, movie = folder / "tracks.npz", folder / "plan.png", folder / "run.webp"
    reported = _lists(capsys, folder / "pings.npz", "--pings", ":12", "--out", out, "--plot", plot, "--movie", movie)
    with np.load(out) as file:
        trk, t, numbers = file["trk"], file["t"], file["ping_number"]
    assert numbers.tolist() == [line["ping_number"] for line in reported] == list(range(12))
    assert t * 1e9 == pytest.approx([line["t_ns"] for line in reported])
    rows = [
        [scan, o["id"], *o["position_ned"][:2], *o["velocity_ned"][:2], o["radius_m"], 1]
        for scan, line in enumerate(reported)
        for o in line["obstacles"]
    ]
    assert rows
    assert trk.tolist() == rows
    with Image.open(movie) as moving, Image.open(plot) as still:
        assert getattr(moving, "n_frames", 1) == 12
        assert still.width > 1000


def test_scores_of_the_truth_beside_it(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["track", str(folder / "pings.npz")]) == 0
    said = capsys.readouterr().out
    assert "ball" in said
    assert "0 false tracks, 0 identity switches" in said


def test_poses_are_known_up_to_the_first_one_after_the_last_echo(folder: Path) -> None:
    """As on board: of each ping the pose at reception is known, and none that comes later."""
    source = open_source(folder / "pings.npz", sonar="")
    steps = list(Mission(MissionSettings()).steps(source.pings, source.poses))
    assert [step.list.poses_until for step in steps[:-1]] == list(range(1, len(steps)))
    assert [step.detections.poses_until for step in steps[:-1]] == list(range(1, len(steps)))


def test_s7k_with_poses(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its poses are put on the earth here, level and heading north: by way of the earth they come back."""
    site, recording = LocalFrame(57.0, 10.0), open_pings(folder / "pings.npz")
    path = folder / "pings.s7k"
    assert recording.position_ned is not None
    write_s7k(path, (msgspec.structs.replace(ping, utc_ns=ping.t_ns + UTC_NS) for ping in recording.pings))
    with path.open("ab") as file:
        for ping, place in zip(recording.pings, recording.position_ned, strict=True):
            latitude, longitude, height = site.geodetic(place)
            pose = GeodeticPose(float(np.radians(latitude)), float(np.radians(longitude)), float(height), 0.0, 0.0, 0.0)
            file.write(encode_pose(pose, ping.t_ns + UTC_NS))
    way = pose_track_of(path, open_pings(path), site)
    assert np.array([pose.position_ned for pose in way.poses]) == pytest.approx(recording.position_ned, abs=1e-6)
    assert way.poses[5].velocity_body == pytest.approx((1.0, 0.2, 0.0), abs=0.01)
    lists = _lists(capsys, path, "--geojson", folder / "ways.json")
    assert len(lists) == len(recording.pings)
    features = json.loads((folder / "ways.json").read_text())["features"]
    vehicle = next(feature for feature in features if feature["properties"]["what"] == "vehicle")
    begin = [float(value) for value in site.geodetic(recording.position_ned[0])]
    assert vehicle["geometry"]["coordinates"][0] == pytest.approx([begin[1], begin[0], begin[2]], abs=2e-3)
    assert {f["properties"]["object"] for f in features if f["properties"]["what"] == "object"} >= {1}


def test_where_a_recording_was_it_tells_itself(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = folder / "recorded.json"
    _lists(capsys, folder / "recorded", "--pings", ":5", "--geojson", out)
    vehicle = json.loads(out.read_text())["features"][0]
    assert vehicle["geometry"]["coordinates"][0][:2] == pytest.approx([20.0, -10.0], abs=0.01)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["absent.npz"], "No such file"),
        (["small.toml"], "small.toml"),
        (["pings.npz", "--movie", "run.mp4"], "the ending must be one of .webp, .gif"),
        (["pings.npz", "--out", "absent/tracks.npz"], "no such folder"),
        (["pings.npz", "--geojson", "ways.json"], "--config with [site]"),
        (["pings.npz", "--pings", "500"], "there is no 500"),
        (["empty"], "no recording in it"),
        (["images.npz"], "have no times"),
        (["blind.npz"], "no poses in it"),
    ],
)
def test_what_cannot_be_tracked_is_one_line(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: list[str], said: str
) -> None:
    monkeypatch.chdir(folder)
    (folder / "empty").mkdir(exist_ok=True)
    with np.load("pings.npz") as file:
        arrays = dict(file)
    np.savez("images.npz", **{name: array for name, array in arrays.items() if name != "t"})
    np.savez("blind.npz", **{name: array for name, array in arrays.items() if name not in ("pos_ned", "quat")})
    assert main(["track", *arguments]) == (1 if "recording" in said else 2)
    reported = capsys.readouterr().err
    assert said in reported
    assert reported.count("\n") == 1


def test_detect_reads_recordings(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = []
    for file in ("pings.npz", "recorded"):
        assert main(["detect", str(folder / file), "--json", "--pings", "3,1,7:9"]) == 0
        said.append(capsys.readouterr().out)
    assert said[0] == said[1]
    assert said[0].count("\n") == 4


def test_pings_of_a_recording_are_read_forwards_and_again(folder: Path) -> None:
    pings = open_source(folder / "recorded", sonar="").pings
    numbers = [0, 3, 3, 1, len(pings) - 1, -2]
    assert [pings[k].ping_number for k in numbers] == [range(len(pings))[k] for k in numbers]
    assert all(isinstance(ping, Ping) for ping in pings[2:5])
