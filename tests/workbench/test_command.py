"""`ods workbench`: what each browser begins with, and errors as one line."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.cli import main
from ods.config import OnboardConfig, part_of
from ods.offline.mission import MissionSettings
from ods.workbench import start
from ods.workbench.command import add_arguments
from ods.workbench.engine.files.config_file import ConfigFile, load_config
from ods.workbench.model.state import State
from ods.workbench.start import folders_of

SCENES = Path(__file__).parents[2] / "config" / "scenes"
CONFIG = Path(__file__).parents[2] / "config" / "onboard.toml"


def arguments(*words: str) -> Namespace:
    parser = ArgumentParser()
    add_arguments(parser)
    parser.add_argument("--config", type=Path)
    return parser.parse_args(words)


def loaded_by(args: Namespace) -> ConfigFile:
    return load_config(args.config)


def first_state(args: Namespace) -> State:
    return start.first_state(args, loaded_by(args))


def test_files_folders_scenes_and_buses_are_distinguished(tmp_path: Path) -> None:
    file = tmp_path / "pings.npz"
    file.touch()
    assert first_state(arguments()).data.kind == "none"
    for path in (file, tmp_path):
        data = first_state(arguments(str(path))).data
        assert (data.kind, data.path) == ("file", str(path))
    assert first_state(arguments("--live", str(tmp_path))).data.kind == "live"
    scene = first_state(arguments(str(SCENES / "figure11.toml")))
    assert scene.data.kind == "scene"
    assert scene.scene is not None
    assert scene.scene.objects


def test_the_configuration_is_what_is_tuned() -> None:
    other = CONFIG.with_name("onboard-oculus.toml")
    config = first_state(arguments("--config", str(other))).tuning.config
    assert config == part_of(load(other, OnboardConfig), MissionSettings)
    assert config != first_state(arguments()).tuning.config == part_of(load(CONFIG, OnboardConfig), MissionSettings)


def test_folders_are_those_named_and_those_of_what_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here, there, named = (tmp_path / name for name in ("here", "there", "named"))
    for folder in (here, there, named):
        folder.mkdir()
    monkeypatch.chdir(here)
    words = (str(there / "x.npz"), "--folder", str(named), "--folder", str(here))
    assert folders_of(arguments(*words)) == (here, there, named)


def test_a_bus_is_a_folder_that_may_yet_be_made(tmp_path: Path) -> None:
    first_state(arguments("--live", str(tmp_path / "later")))
    file = tmp_path / "mission.mcap"
    file.touch()
    with pytest.raises(OdsError, match=r"--live: .*mission\.mcap is no folder"):
        first_state(arguments("--live", str(file)))


@pytest.mark.parametrize(
    ("words", "reported"),
    [
        (("no.npz",), "no.npz: no such file or folder"),
        (("--live", ".", "x.npz"), "--live: goes without a file"),
        (("--folder", "nowhere"), "--folder: {here}/nowhere: no such folder"),
        (("bad.toml",), "bad.toml: not valid TOML: "),
        (("--config", "bad.toml"), "bad.toml: not valid TOML: "),
    ],
)
def test_errors_are_one_line(
    words: tuple[str, ...],
    reported: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.toml").write_text("[")
    assert main(["workbench", "--no-browser", *words]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"ods workbench: {reported.format(here=tmp_path)}")
    assert error.count("\n") == 1
