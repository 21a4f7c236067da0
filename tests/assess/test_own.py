"""The user's own frames, labels and scenes, judged as by the user: in a folder of his own."""

from pathlib import Path

import numpy as np
import pytest

from ods.assess.detection.own import configured
from ods.assess.track.scene_world import world_of
from ods.base.errors import OdsError
from ods.cli import main
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.scene.timeline import load_scene
from ods.sonar_link.files.npz_writer import write_ping_file
from tests.pipeline.pings import make_ping

pytestmark = pytest.mark.slow

SCENES = Path(__file__).parents[2] / "config" / "scenes"
CHAIN = '[[pipeline.stage]]\nuse = "filter.box"\n[[pipeline.stage]]\nuse = "detect.one_level"\nlevel = 20.0\n'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Three pings with an object in beams 12 to 15 and samples 200 to 219 of the last two."""
    frames = np.random.default_rng(1).rayleigh(20.0, (3, 32, 500))
    frames[1:, 12:16, 200:220] += 400.0
    pings = [make_ping(frame.astype(np.uint16), seq=k, t_ns=k * 10**8) for k, frame in enumerate(frames)]
    write_ping_file(tmp_path / "dive.npz", pings)
    (tmp_path / "labels.txt").write_text("# frame, beams, samples\n1 11 16 195 225 box\n2 11 16 195 225 box\n")
    (tmp_path / "mine.toml").write_text(f"[pipeline]\n{CHAIN}")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_settings_are_judged_on_labelled_frames_and_the_configured_chain_is_one(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["--own", "--quick", "--real", "dive.npz", "labels.txt", "--config", "mine.toml"]
    assert main(["assess", "detect", *asked]) == 0
    text = capsys.readouterr().out
    assert "2 objects on 2 images" in text
    (row,) = [line for line in text.splitlines() if " configured " in line]
    assert [cell.strip() for cell in row.split("│")[3:-1]] == ["1.000", "", "", "1.000", "0.0"]
    assert text.count(" no filter, ") == 3


@pytest.mark.parametrize(
    ("detector", "swept"),
    [({"use": "detect.two_level", "min_cells": 9}, "high"), ({"use": "detect.cfar"}, "rate"),
     ({"use": "detect.cfar", "method": "os"}, "rate"), ({"use": "detect.one_level"}, "level")],
)  # fmt: skip
def test_a_chain_s_threshold_is_swept_whatever_else_it_sets(detector: dict[str, object], swept: str) -> None:
    setting = configured(PipelineSettings(stage=({"use": "filter.box"}, detector)))
    last = [each.chain()[-1] for each in setting.settings]
    assert len({stage[swept] for stage in last}) == len(last) >= 3
    assert all(detector.items() <= stage.items() for stage in last)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["--own"], "--real, --scene: no object is in view of any image"),
        (["--scene", "s.toml"], "--scene, --config: only with --own"),
        (["--own", "--scene", "."], "not valid"),
        (["--own", "--real", "dive.npz", "no.txt"], "no.txt: No such file"),
    ],
)
def test_what_cannot_be_judged_is_one_line(
    folder: Path, capsys: pytest.CaptureFixture[str], asked: list[str], said: str
) -> None:
    (folder / "broken.toml").write_text("[")
    (folder / "mine.toml").unlink()
    assert main(["assess", "detect", *asked]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_scene_is_a_scenario(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = load_scene(SCENES / "worked_example.toml")
    world = world_of(scene)
    k = 70
    there = scene.objects_at(float(world.t[k]))
    np.testing.assert_allclose(world.truth[k, :, :3], there.position_ned)
    np.testing.assert_allclose(world.truth[k, :, 6], there.radius_m)
    np.testing.assert_allclose(np.gradient(world.truth[:, 0, 0], world.t)[k], world.truth[k, 0, 3], atol=1e-6)
    assert main(["assess", "track", "--scene", str(SCENES / "empty.toml")]) == 2
    assert "there is no object to track" in capsys.readouterr().err


def test_scenes_have_objects_that_count_however_strong(folder: Path) -> None:
    from ods.assess.detection.own import IMAGES_OF_A_SCENE, own_images
    from ods.base.files.shipped import shipped_file
    from ods.sim_sonar.sonar.model import load_sonar

    sonar = load_sonar(shipped_file("sonars/seabat6012.toml"))
    images = own_images([], [SCENES / "figure11.toml"], sonar)
    assert len(images) == IMAGES_OF_A_SCENE
    assert all(target.counts and target.circle for image in images for target in image.targets)
    with pytest.raises(OdsError, match="no object"):
        own_images([], [SCENES / "empty.toml"], sonar)
