"""`ods detect` as a user runs it, in a folder of his own."""

import json
from argparse import ArgumentTypeError
from pathlib import Path

import numpy as np
import pytest

from ods.base.command_line.arguments import choice
from ods.cli import main
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.settings import AttentionSettings, PipelineSettings
from ods.pipeline.stage.watch import RECORDED, StageImage
from ods.sonar_link.files.npz_writer import write_ping_file
from tests.pipeline.pings import make_ping
from tests.recording.mcap_samples import pose, write_segment

pytestmark = pytest.mark.slow

PNG = b"\x89PNG"
COUNT = 12
EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


def ping(number: int) -> Ping:
    """A ping with an echo that moves away by 20 samples a ping."""
    frame = np.random.default_rng(number).rayleigh(20.0, (32, 500))
    frame[12:16, 100 + 20 * number : 120 + 20 * number] += 300.0
    return make_ping(frame.astype(np.uint16), seq=number, t_ns=number * 10**8)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write_ping_file(tmp_path / "pings.npz", [ping(number) for number in range(COUNT)])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def places(capsys: pytest.CaptureFixture[str], which: str) -> list[int]:
    assert main(["detect", "pings.npz", "--json", f"--pings={which}"]) == 0
    return [json.loads(line)["index"] for line in capsys.readouterr().out.splitlines()]


def test_pings_are_chosen_and_keep_their_numbers(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert places(capsys, "2:5") == [2, 3, 4]
    assert places(capsys, "::5") == [0, 5, 10]
    assert places(capsys, "7,-1,0:2,1") == [0, 1, 7, 11]
    assert main(["detect", "pings.npz", "--pings", "3:5", "--out", "det.npz", "--mask", "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    with np.load(folder / "det.npz") as saved:
        assert set(saved["det"][:, 0]) == {3.0, 4.0}
        strongest = saved["det"][saved["det"][:, 4].argsort()[-2:]]
        np.testing.assert_allclose(np.sort(strongest[:, 1]), [8.5, 9.5], atol=0.5)


@pytest.mark.parametrize("which", ["12", "20:", "-13", "5:5"])
def test_a_choice_of_nothing_is_one_line(folder: Path, capsys: pytest.CaptureFixture[str], which: str) -> None:
    assert main(["detect", "pings.npz", f"--pings={which}"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"ods detect: --pings {which}")
    assert said.endswith("there are 12, 0 to 11\n")
    assert said.count("\n") == 1


@pytest.mark.parametrize("text", ["", "a", "1:2:3:4", "::0", "1.5", "1,,2", "1;2"])
def test_what_is_no_range_is_refused(text: str) -> None:
    with pytest.raises(ArgumentTypeError):
        choice(text)


def test_pictures_one_a_ping_one_for_all_and_one_of_the_stages(folder: Path) -> None:
    asked = ["--quiet", "--pings", "::6", "--plot", "p.png", "--sheet", "sheet.png", "--plot-stages", "stages.png"]
    assert main(["detect", "pings.npz", *asked]) == 0
    drawn = {file.name: file.read_bytes()[:4] for file in folder.glob("*.png")}
    assert drawn == dict.fromkeys(["p-0.png", "p-6.png", "sheet.png", "stages-0.png", "stages-6.png"], PNG)


def test_pictures_that_cannot_be_are_one_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_ping_file(folder / "many.npz", [ping(0)] * 49)
    assert main(["detect", "many.npz", "--sheet", "sheet.png"]) == 2
    assert capsys.readouterr().err == "ods detect: --sheet: 49 pings, and 48 fit: choose some by --pings\n"
    assert main(["detect", "pings.npz", "--pings", "0", "--plot-stages", "none/stages.png", "--quiet"]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_recording_without_a_ping_is_one_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_segment(folder / "silent.mcap", [("pose", 1_009_000_000, pose(0, 1_000_000_000))])
    assert main(["detect", "silent.mcap", "--quiet", "--sheet", "sheet.png"]) == 2
    assert capsys.readouterr().err == "ods detect: silent.mcap: no pings in it\n"


@pytest.mark.usefixtures("registers")
def test_a_format_of_ones_own_is_read(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code = (EXAMPLES / "user_decoder.py").read_text().replace("SKETCH01", "SKETCHED").replace("Sketch .", "Sketched .")
    (folder / "mine.py").write_text(code)
    (folder / "mine.toml").write_text('[recordings]\nplugins = ["mine.py"]\n')
    (folder / "dive.sketch").write_bytes(b"SKETCHED" + np.array([2, 32, 500], "<u4").tobytes() + bytes(2 * 32 * 500))
    assert main(["detect", "dive.sketch", "--config", "mine.toml"]) == 0
    assert capsys.readouterr().out.splitlines()[:2] == ["ping 0: 0 detections", "ping 1: 0 detections"]
    (folder / "mine.toml").write_text('[recordings]\nplugins = ["away.py"]\n')
    assert main(["detect", "dive.sketch", "--config", "mine.toml"]) == 2
    assert capsys.readouterr().err.startswith(f"ods detect: recordings.plugins[0] ({folder / 'away.py'}): ")


def test_what_stages_make_is_shown_in_order_with_the_levels_that_were_set() -> None:
    stages = ({"use": "equalize.mean_range"}, {"use": "filter.box"})
    detector = {"use": "detect.two_level", "levels": "absolute", "low": 2.0, "high": 4.0}
    seen: list[StageImage] = []
    settings = PipelineSettings(stage=(*stages, detector))
    watched = Chain(settings, watch=seen.append).process(ping(2))
    assert [each.label for each in seen] == [RECORDED, "equalize.mean_range", "filter.box", "detect.two_level"]
    assert watched.detections == Chain(settings).process(ping(2)).detections
    recorded, _, boxed, judged = seen
    counts = np.frombuffer(ping(2).data, np.uint16).reshape(32, 500)[:, -recorded.image.shape[1] :]
    np.testing.assert_array_equal(recorded.image, counts + 0.5)
    np.testing.assert_array_equal(judged.image, boxed.image)
    assert judged.levels == (2.0, 4.0)
    mean = np.lib.stride_tricks.sliding_window_view(seen[1].image, 9, axis=1).mean(axis=-1)
    np.testing.assert_allclose(boxed.image[:, 4:-4], mean, rtol=1e-4)


def test_rings_of_ranges_are_shown_apart() -> None:
    seen: list[StageImage] = []
    attention = AttentionSettings(near_m=10.0, every=2, margin_m=1.0, subsample=1)
    chain = Chain(PipelineSettings(attention=attention), watch=seen.append)
    for number in range(2):
        chain.process(ping(number))
    reach = [float(each.fan.range_m[-1]) for each in seen if each.label == RECORDED]
    assert len(reach) == 2
    assert max(reach) == pytest.approx(24.95)
    assert min(reach) == pytest.approx(10.0 + 7.5 + 1.0, abs=0.1)


@pytest.mark.parametrize(
    "command",
    [
        ["detect", "pings.npz", "--plot", "x.docx"],
        ["detect", "pings.npz", "--sheet", "x.docx"],
        ["track", "pings.npz", "--plot", "x.docx"],
        ["simulate", "--chart", "x.docx"],
        ["assess", "detect", "--out", "x.docx"],
        ["assess", "sea", "--out", "x.docx"],
        ["assess", "track", "--out", "x.docx"],
    ],
)
@pytest.mark.usefixtures("folder")
def test_a_picture_that_cannot_be_drawn_is_refused_before_the_work(
    command: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "x.docx: the ending must be one of " in err
    assert ".png" in err
