import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import msgspec
import numpy as np
import pytest

from ods.base.arrays import AnyArray
from ods.base.errors import OdsError
from ods.cli import main
from ods.messages import Truth, frame_of
from ods.sim_sonar.device.sonar_line import open_sonar
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.settings import SimSettings
from ods.sim_sonar.shots import Shot, shots_of
from ods.sim_sonar.sonar.model import load_sonar
from ods.simulate import speed as simulate_speed
from ods.sonar_link.files.opening import open_pings

CONFIG = Path(__file__).parents[2] / "config"
SCENE = CONFIG / "scenes/figure11_imperfect.toml"

SMALL = """
name = "small"
frequency_hz = 1e6
beams_per_plane = 12
beam_spacing_deg = 3.0
beam_width_deg = 3.0
range0_m = 0.2
dr_m = 0.2
samples = 300
"""


@pytest.fixture
def small(tmp_path: Path) -> str:
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return str(path)


def run(*words: object) -> int:
    return main(["simulate", *map(str, words)])


def truths_in(path: Path) -> list[Truth]:
    return [msgspec.json.decode(line, type=Truth) for line in path.read_bytes().splitlines()]


def in_frames(images: ImageSimulator, count: int) -> AnyArray:
    period = images.sonar.ping_period_s
    return np.stack([frame_of(images.ping(round(k * period * 1e9) / 1e9, k, 0, 0)) for k in range(count)])


@pytest.mark.parametrize("name", ["pings.npz", "pings.s7k"])
def test_recording_holds_what_the_live_simulator_sends(tmp_path: Path, small: str, name: str) -> None:
    out = tmp_path / name
    assert run(SCENE, "--sonar", small, "--out", out, "--pings", 4) == 0
    images = ImageSimulator(load_sonar(Path(small)), load_scene(SCENE))
    read = open_pings(out)
    np.testing.assert_array_equal(np.stack([frame_of(ping) for ping in read.pings]), in_frames(images, 4))
    times = np.array([ping.t_ns for ping in read.pings], np.float64)
    np.testing.assert_allclose(np.diff(times), 1e9 * images.sonar.ping_period_s, rtol=1e-4)
    truths = truths_in(tmp_path / "pings.truth.jsonl")
    assert [truth.ping_number for truth in truths] == [0, 1, 2, 3]
    assert truths[3].objects == images.truth(truths[3].t_ns / 1e9, 3)
    assert truths[3].objects[0].peak_db > truths[3].objects[0].background_db


def test_npz_has_pose_and_truth(tmp_path: Path, small: str) -> None:
    out = tmp_path / "pings.npz"
    assert run(SCENE, "--sonar", small, "--out", out, "--pings", 3) == 0
    read = open_pings(out)
    scene = load_scene(SCENE)
    assert read.truth is not None
    assert read.position_ned is not None
    period = load_sonar(Path(small)).ping_period_s
    np.testing.assert_allclose(read.position_ned[2], scene.vehicle_at(2 * period).position_ned, atol=1e-6)
    states = scene.objects_at(2 * period)
    expected = np.column_stack([states.position_ned, states.velocity_ned, states.radius_m])
    np.testing.assert_allclose(read.truth[2], expected, atol=1e-6)


def test_whole_scene_without_pings_and_the_seed(tmp_path: Path, small: str) -> None:
    scene = tmp_path / "short.toml"
    scene.write_text(SCENE.read_text().replace("duration_s = 60.0", "duration_s = 1.0"))
    files = []
    for folder, seed in (("a", []), ("b", []), ("c", ["--seed", 3])):
        (tmp_path / folder).mkdir()
        files.append(tmp_path / folder / "pings.s7k")
        assert run(scene, "--sonar", small, "--out", files[-1], *seed) == 0
    a, b, c = (path.read_bytes() for path in files)
    assert a == b != c
    assert len(open_pings(files[0]).pings) == int(1.0 / load_sonar(Path(small)).ping_period_s) + 1


def test_scene_without_objects(tmp_path: Path, small: str) -> None:
    assert run(CONFIG / "scenes/empty.toml", "--sonar", small, "--out", tmp_path / "a.npz", "--pings", 2) == 0
    read = open_pings(tmp_path / "a.npz")
    assert read.truth is not None
    assert read.truth.shape == (2, 0, 7)


def test_pictures(tmp_path: Path, small: str) -> None:
    assert run(SCENE, "--sonar", small, "--out", tmp_path / "one.png") == 0
    assert run(SCENE, "--sonar", small, "--out", tmp_path / "many.png", "--pings", 2) == 0
    names = sorted(path.name for path in tmp_path.glob("*.png"))
    assert names == ["many-0000.png", "many-0001.png", "one.png"]
    assert not list(tmp_path.glob("*.jsonl"))
    assert (tmp_path / "one.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_names_are_found_from_any_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scenes").mkdir()
    (tmp_path / "sonars").mkdir()
    (tmp_path / "scenes/mine.toml").write_text((CONFIG / "scenes/empty.toml").read_text())
    (tmp_path / "sonars/own.toml").write_text(SMALL)
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    for sonar, beams in (("own", 12), ("seabat6012", 60)):
        assert run("../scenes/mine.toml", "--sonar", sonar, "--out", "x.npz", "--pings", 1) == 0
        assert open_pings(Path("x.npz")).pings[0].beams == beams


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([SCENE], "give SCENE.toml and --out, or --chart, or --table"),
        ([SCENE, "--out", "x.jpg"], "x.jpg: the ending must be one of .npz, .s7k, .png"),
        (["none.toml", "--out", "x.npz"], "none.toml: No such file or directory"),
        (
            [SCENE, "--sonar", "sonic", "--out", "x.npz"],
            "sonar: 'sonic' is not one of multibeam512, norbit_wbms_fls, oculus_m750d, ping",
        ),
        (["--chart", "x.html"], "x.html: the ending must be one of "),
        ([SCENE, "--out", "nowhere/x.npz"], "nowhere/x.npz: no such folder: nowhere"),
    ],
)
def test_errors_are_one_line(
    words: list[object], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(CONFIG, tmp_path / "config")
    monkeypatch.chdir(tmp_path)
    assert run(*words) == 2
    reported = capsys.readouterr().err
    assert reported.startswith(f"ods simulate: {said}")
    assert reported.count("\n") == 1


@pytest.mark.parametrize(
    ("line", "name", "said"),
    [
        ('samples = "linear8"', "x.s7k", "image.samples: s7k has no record for linear8"),
        ("beam_gain_db = [1.0]", "x.npz", "image.beam_gain_db: 1 values for the 12 beams of small"),
    ],
)
def test_scenes_that_do_not_fit_are_one_line(
    line: str, name: str, said: str, tmp_path: Path, small: str, capsys: pytest.CaptureFixture[str]
) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text((CONFIG / "scenes/empty.toml").read_text() + f"[image]\n{line}\n")
    assert run(scene, "--sonar", small, "--out", tmp_path / name) == 2
    assert capsys.readouterr().err == f"ods simulate: {scene}: {said}\n"


def test_a_first_range_that_s7k_cannot_tell_is_one_line(
    tmp_path: Path, small: str, capsys: pytest.CaptureFixture[str]
) -> None:
    sonar, scene = tmp_path / "odd.toml", CONFIG / "scenes/empty.toml"
    sonar.write_text(re.sub("range0_m = .*", "range0_m = 0.72", Path(small).read_text()))
    said = f"{sonar}: range0_m: 0.72 is not a multiple of dr_m (0.2), as s7k records require"
    assert run(scene, "--sonar", sonar, "--out", tmp_path / "x.s7k") == 2
    assert capsys.readouterr().err == f"ods simulate: {said}\n"
    images = ImageSimulator(load_sonar(sonar), load_scene(scene))
    with pytest.raises(OdsError, match=re.escape(said)):
        open_sonar(SimSettings(scene, sonar, ins_eds=scene), tmp_path, images)


def test_wrong_number_of_pings(capsys: pytest.CaptureFixture[str]) -> None:
    for wrong in ("0", "-3", "many"):
        with pytest.raises(SystemExit) as left:
            run(SCENE, "--out", "x.npz", "--pings", wrong)
        assert left.value.code == 2
    assert "is not a whole number above 0" in capsys.readouterr().err


# --- error and time


def test_errors_of_a_mean_image() -> None:
    reference = np.ones((20, 100))
    assert simulate_speed.relative_error(reference, reference) == 0.0
    assert simulate_speed.relative_error(1.1 * reference, reference) == pytest.approx(0.1)
    assert simulate_speed.relative_error(0.0 * reference, 0.0 * reference) == 0.0
    shaken = reference + np.random.default_rng(1).normal(0.0, 0.27, reference.shape)
    assert simulate_speed.relative_error(shaken, reference) == pytest.approx(0.27 / np.sqrt(27.0), rel=0.25)


def test_parts_and_curves_are_measured(small: str) -> None:
    once = simulate_speed.Effort(1, 0.0)
    sonar = load_sonar(Path(small))
    parts = simulate_speed.parts_of(sonar, load_scene(SCENE), once)
    assert list(parts) == list(simulate_speed.TABLE_1)
    assert parts["total"] > 0.0
    curve = simulate_speed.curve_of(sonar, "figure11", once)
    errors = [point.error for point in curve.points]
    assert errors[0] > errors[-1]
    assert curve.picked.error < curve.picked.max_error
    empty = simulate_speed.curve_of(sonar, "empty", once)
    assert {point.error for point in empty.points} == {0.0}


@pytest.mark.parametrize("suffix", [".npz", ".s7k"])
def test_what_is_interrupted_leaves_what_was_there(
    tmp_path: Path, small: str, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    def interrupted(images: ImageSimulator) -> Iterator[Shot]:
        yield next(shots_of(images))
        raise KeyboardInterrupt

    monkeypatch.setattr("ods.simulate.simulation.shots_of", interrupted)
    files = [tmp_path / f"pings{suffix}", tmp_path / "pings.truth.jsonl"]
    for file in files:
        file.write_text("old")
    there = sorted(tmp_path.iterdir())
    assert run(CONFIG / "scenes/empty.toml", "--sonar", small, "--out", files[0], "--pings", 3) == 130
    assert sorted(tmp_path.iterdir()) == there
    assert [file.read_text() for file in files] == ["old", "old"]
