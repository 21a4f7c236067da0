"""Stages by name: parameters, complaints, stages of the user's own."""

import importlib
import subprocess
import sys
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from ods.base import plugins
from ods.base.arrays import Image
from ods.base.plugins import PluginError
from ods.base.settings import Positive, Settings
from ods.base.settings_file import ConfigError, load
from ods.config import OnboardConfig
from ods.pipeline.chain import Chain
from ods.pipeline.image.fan import Fan
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.configured import find_stage, stage_names
from ods.pipeline.stage.params import BUILT_IN, STAGES, StageError
from ods.pipeline.stage.registry import REGISTERED, image_stage
from ods.pipeline.stage.step import ImageStep
from tests.pipeline.pings import make_ping

REPOSITORY = Path(__file__).parents[2]
EXAMPLE = REPOSITORY / "docs" / "examples" / "user_stage.py"
DETECT = {"use": "detect.two_level"}


def chain(*stages: dict[str, Any], plugins: tuple[Path, ...] = ()) -> Chain:
    return Chain(PipelineSettings(stage=stages, plugins=plugins))


@pytest.fixture
def frame() -> np.ndarray:
    frame = np.random.default_rng(4).rayleigh(20.0, (16, 400))
    frame[6:9, 200:220] *= 6.0
    return frame.astype(np.uint16)


@pytest.mark.parametrize(
    ("stages", "complaint"),
    [
        ([DETECT, {"use": "filter.fir"}], "pipeline.stage: exactly the last stage must be one that detects"),
        ([{"use": "filter.fir"}], "pipeline.stage: exactly the last stage must be one that detects"),
        ([DETECT, DETECT], "pipeline.stage: exactly the last stage must be one that detects"),
    ],
)
def test_wrong_chains_are_one_line(stages: list[dict[str, Any]], complaint: str) -> None:
    with pytest.raises(StageError) as caught:
        chain(*stages)
    assert str(caught.value).startswith(complaint)
    assert "\n" not in str(caught.value)


def test_unknown_stage_lists_the_known_ones() -> None:
    with pytest.raises(ValueError, match=r"stage\[0\]\.use: .* \(did you mean filter\.fir\)") as caught:
        chain({"use": "filter.fri"}, DETECT)
    assert all(name in str(caught.value) for name in BUILT_IN)


@pytest.mark.parametrize(
    ("stage", "complaint"),
    [
        ('use = "filter.fir"\ntaps = "many"', "stage[0] (filter.fir): taps: expected an integer, got a string"),
        ('use = "filter.fir"\ntaps = 0', "stage[0] (filter.fir): taps: must be at least 1 (samples)"),
        ('use = "filter.fir"\ntabs = 9', "stage[0] (filter.fir): tabs: unknown key"),
        ('use = "filter.median"\nwindow = 4', "stage[0] (filter.median): window: 4 is not one of 3, 5, 7, 9"),
        ('use = "filter.fir"\ntaps = 8', "stage[0] (filter.fir): taps: expected an odd number, got 8"),
        ('use = "detect.two_level"\nlow = 9.0', "stage[0] (detect.two_level): low: 9.0 is above high, 6.0"),
        ("taps = 9", "stage[0].use: missing"),
    ],
)
def test_parameters_are_checked_with_the_configuration_file(tmp_path: Path, stage: str, complaint: str) -> None:
    text = (REPOSITORY / "config" / "onboard.toml").read_text()
    file = tmp_path / "onboard.toml"
    file.write_text(f"{text}\n[[pipeline.stage]]\n{stage}\n")
    with pytest.raises(ConfigError) as caught:
        load(file, OnboardConfig)
    assert complaint in str(caught.value)
    assert "pipeline" in str(caught.value)


def test_configuration_is_checked_without_kernels_and_scipy() -> None:
    code = "import sys, ods.config; sys.exit('ods.compiled' in sys.modules or 'scipy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_stage_that_comes_with_ods_is_in_the_table_of_parameters() -> None:
    ours = {name: find_stage(name) for name in stage_names()}
    table = {name: stage.params for name, stage in ours.items() if stage.prepare.__module__.startswith("ods.pipeline")}
    assert table == dict(BUILT_IN)


def test_users_file_is_found_and_its_parameters_are_checked(frame: np.ndarray) -> None:
    user = {"use": "my.beam_gain", "limit": 3.0}
    built = chain({"use": "equalize.mean_range"}, user, {"use": "filter.box"}, DETECT, plugins=(EXAMPLE,))
    assert built.process(make_ping(frame)).detections
    with pytest.raises(StageError, match=r"pipeline.stage\[0\] \(my.beam_gain\): limit: must be more than 0"):
        chain({"use": "my.beam_gain", "limit": -1.0}, DETECT, plugins=(EXAMPLE,))


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_stage_stands_in_the_file_of_its_name_or_in_one_that_lists_it(name: str) -> None:
    module = importlib.import_module(find_stage(name).prepare.__module__)
    folder, word = name.split(".")
    assert module.__name__.startswith(f"ods.pipeline.{folder}.")
    assert module.__name__.endswith(f".{word}") or f"`{word}`" in (module.__doc__ or "")


def test_document_shows_the_very_example() -> None:
    code = EXAMPLE.read_text().partition('"""\n\n')[2]
    assert code in (REPOSITORY / "docs" / "pipeline" / "user-stage.md").read_text()


def test_users_file_is_named_relative_to_the_configuration(tmp_path: Path) -> None:
    text = (REPOSITORY / "config" / "onboard.toml").read_text()
    file = tmp_path / "onboard.toml"
    file.write_text(text.replace("[pipeline]", '[pipeline]\nplugins = ["stages/mine.py"]'))
    assert load(file, OnboardConfig).pipeline.plugins == (tmp_path / "stages" / "mine.py",)


def test_users_stage_does_what_it_says() -> None:
    STAGES.load([EXAMPLE])
    stage = find_stage("my.beam_gain")
    source = np.array([[1.0, 2.0, 3.0], [10.0, 20.0, 30.0]], np.float32)
    out = np.empty_like(source)
    fan = Fan(np.array([0.0, 0.1]), np.full(2, 0.1), 3, 0.0, 0.05)
    stage.prepare(stage.params(), fan)(source, out)
    np.testing.assert_allclose(out, [[0.5, 1.0, 1.5], [2.5, 5.0, 7.5]])


def test_plugin_of_another_package_is_found_by_its_entry_point(
    monkeypatch: pytest.MonkeyPatch, frame: np.ndarray
) -> None:
    class Double(Settings, frozen=True):
        by: Positive = 2.0

    class Entry:
        name = "double"

        def load(self) -> None:
            @image_stage("other.double", Double)
            def double(params: Double, fan: Fan) -> ImageStep:
                def step(source: Image, out: Image) -> None:
                    np.multiply(source, params.by, out=out)

                return step

    plain = chain({"use": "equalize.mean_range"}, DETECT).process(make_ping(frame))
    monkeypatch.setattr(plugins, "installed", lambda group: [Entry()] if group == "ods.stages" else [])
    with patch.dict(REGISTERED):
        built = chain({"use": "equalize.mean_range"}, {"use": "other.double"}, DETECT)
        assert [d.range_m for d in built.process(make_ping(frame)).detections] == [d.range_m for d in plain.detections]


@pytest.mark.parametrize(
    ("code", "complaint"),
    [
        ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
        ("def f(:", "SyntaxError"),
        ("raise RuntimeError('two\\nlines')", "RuntimeError: two lines"),
        (
            "from ods.pipeline.stage.registry import image_stage\nfrom ods.base.settings import Settings\n"
            "image_stage('filter.fir', Settings)(print)",
            "stage filter.fir: the name is already taken by ods.pipeline.filter.linear.fir",
        ),
    ],
)
def test_broken_plugin_is_one_line(tmp_path: Path, code: str, complaint: str) -> None:
    file = tmp_path / "plugin.py"
    file.write_text(code)
    with pytest.raises(PluginError) as caught:
        chain(DETECT, plugins=(file,))
    assert str(caught.value).startswith(f"pipeline.plugins[0] ({file}): ")
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_plugin_is_one_line(tmp_path: Path) -> None:
    for file in (tmp_path / "none.py", tmp_path / "none.txt"):
        with pytest.raises(PluginError, match="none"):
            chain(DETECT, plugins=(file,))


@pytest.mark.parametrize("where", ["prepare", "step"])
def test_failing_stage_is_named(tmp_path: Path, frame: np.ndarray, where: str) -> None:
    file = tmp_path / "failing.py"
    file.write_text(
        f"""
from ods.pipeline.stage.registry import image_stage
from ods.base.settings import Settings
@image_stage("fails.in_{where}", Settings)
def fails(params, fan):
    {"1 / 0" if where == "prepare" else ""}
    def step(source, out):
        1 / 0
    return step
"""
    )
    built = chain({"use": f"fails.in_{where}"}, DETECT, plugins=(file,))
    with pytest.raises(StageError, match=rf"pipeline.stage\[0\] \(fails.in_{where}\): ZeroDivisionError"):
        built.process(make_ping(frame))


def test_stage_that_gives_nan_is_named(tmp_path: Path, frame: np.ndarray) -> None:
    file = tmp_path / "nan.py"
    file.write_text(
        """
import numpy as np
from ods.pipeline.stage.registry import image_stage
from ods.base.settings import Settings
@image_stage("gives.nan", Settings)
def nan(params, fan):
    return lambda source, out: out.fill(np.nan)
"""
    )
    built = chain({"use": "gives.nan"}, DETECT, plugins=(file,))
    with pytest.raises(StageError, match=r"stage\[0\] \(gives.nan\): its image has values that are not finite"):
        built.process(make_ping(frame))
