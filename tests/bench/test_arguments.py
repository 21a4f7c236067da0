"""What the command line of `ods bench` puts in place of its configuration."""

from argparse import ArgumentParser
from pathlib import Path

import pytest

from ods.base.files.shipped import shipped_file
from ods.base.settings_file import load
from ods.bench import mission
from ods.bench.command import add_arguments
from ods.bench.settings import BenchConfig


def overridden(*words: str) -> BenchConfig:
    parser = ArgumentParser()
    add_arguments(parser)
    return mission._overridden(load(shipped_file("bench.toml"), BenchConfig), parser.parse_args(words))


def test_scene_and_configuration_are_those_of_the_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    settings = overridden("--scene", "mine.toml", "--onboard", "tuned.toml", "--seconds", "5", "--out", "out")
    assert settings.sim.scene == tmp_path / "mine.toml"
    assert settings.onboard == tmp_path / "tuned.toml"
    assert (settings.seconds, settings.out) == (5.0, tmp_path / "out")


def test_without_words_all_is_as_configured() -> None:
    assert overridden() == load(shipped_file("bench.toml"), BenchConfig)
