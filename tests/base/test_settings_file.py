"""One table of a TOML file, and a worker's part of a whole configuration."""

from pathlib import Path

import pytest

from ods.base.geodesy import SiteSettings
from ods.base.settings import Settings
from ods.base.settings_file import ConfigError, load, load_table
from ods.config import OnboardConfig, part_of
from ods.nav_bridge.settings import NavSettings
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.sonar.settings import SonarFile
from ods.sonar_link.files.fan_image import FanGeometry
from ods.tracker.settings import TrackerConfig

CONFIG = Path(__file__).parents[2] / "config"


def test_one_table_is_read_and_the_others_are_not_looked_at(tmp_path: Path) -> None:
    file = tmp_path / "some.toml"
    file.write_text("[other]\nx = true\n[site]\nlatitude_deg = 57\nlongitude_deg = 9.5\n")
    assert load_table(file, "site", SiteSettings) == SiteSettings(latitude_deg=57.0, longitude_deg=9.5)


def test_a_file_of_an_editor_that_marks_its_encoding_is_read(tmp_path: Path) -> None:
    file = tmp_path / "some.toml"
    file.write_bytes(b"\xef\xbb\xbf[site]\r\nlatitude_deg = 57\r\nlongitude_deg = 9.5\r\n")
    assert load_table(file, "site", SiteSettings) == SiteSettings(latitude_deg=57.0, longitude_deg=9.5)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("[other]", "site: missing"),
        ("[site]\nlatitude_deg = 57", "site.longitude_deg: missing"),
        ("[site]\nlatitude_deg = 91\nlongitude_deg = 0", "site.latitude_deg: must be at most 90 (degrees)"),
    ],
)
def test_a_wrong_table_is_one_line_with_its_key(tmp_path: Path, text: str, complaint: str) -> None:
    file = tmp_path / "some.toml"
    file.write_text(text)
    with pytest.raises(ConfigError) as refused:
        load_table(file, "site", SiteSettings)
    assert str(refused.value) == f"{file}: {complaint}"


def test_a_worker_gets_its_part() -> None:
    config = load(CONFIG / "onboard.toml", OnboardConfig)
    part = part_of(config, TrackerConfig)
    assert (part.site, part.pose, part.tracker) == (config.site, config.pose, config.tracker)


def test_a_user_without_a_home_loads_what_names_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def nobody(_: int) -> None:
        raise KeyError

    monkeypatch.delenv("HOME")
    monkeypatch.setattr("pwd.getpwuid", nobody)
    file = tmp_path / "paths.toml"
    file.write_text('here = "~/map"\nother = "~no-such-user/map"\n')
    assert load(file, Paths) == Paths(here=Path("/nonexistent/map"), other=Path("/nonexistent/map"))


class Paths(Settings, frozen=True, kw_only=True):
    here: Path
    other: Path


@pytest.mark.parametrize(
    ("file", "kind", "complaint"),
    [
        ("onboard.toml", SceneFile, "is a configuration of the processes, not a scene"),
        ("bench.toml", OnboardConfig, "is one of the bench, not a configuration of the processes"),
        ("scenes/figure11.toml", OnboardConfig, "is a scene, not a configuration of the processes"),
        ("scenes/figure11.toml", SonarFile, "is a scene, not a simulated sonar"),
        ("sonars/seabat6012.toml", FanGeometry, "is a simulated sonar, not the geometry of a fan"),
    ],
)
def test_a_file_of_another_kind_is_reported_to_be_that(file: str, kind: type[Settings], complaint: str) -> None:
    with pytest.raises(ConfigError) as refused:
        load(CONFIG / file, kind)
    assert str(refused.value) == f"{CONFIG / file}: {complaint}"


def test_a_key_of_very_many_parts_costs_no_time(tmp_path: Path) -> None:
    """4 MB of them took the parser minutes."""
    file = tmp_path / "x.toml"
    file.write_text("".join("a." * 20_000 + f"b{line} = 1\n" for line in range(50)))
    with pytest.raises(ConfigError, match="a key of more than 200 parts"):
        load(file, SceneFile)


def test_many_numbers_in_a_line_are_no_key(tmp_path: Path) -> None:
    file = tmp_path / "x.toml"
    file.write_text(f"bearing_deg = [{', '.join(f'{k}.5' for k in range(300))}]\n")
    with pytest.raises(ConfigError, match="bearing_deg: unknown key"):
        load(file, SceneFile)


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("lever_arm_m = [3700.0, 0.0, 0.0]", "nav.lever_arm_m[0]: must be at most 100 (metres)"),
        ("stale_s = -1", "nav.stale_s: must be more than 0 (seconds)"),
        ("canopen = { inz = 1 }", "nav.canopen.inz: unknown key (did you mean ins_eds)"),
        ("nmae = 1", "nav.nmae: unknown key (did you mean nmea)"),
    ],
)
def test_a_number_out_of_bounds_is_said_in_its_unit_and_an_unknown_key_with_what_was_meant(
    tmp_path: Path, line: str, complaint: str
) -> None:
    file = tmp_path / "some.toml"
    file.write_text(f"[nav]\n{line}\n")
    with pytest.raises(ConfigError) as refused:
        load_table(file, "nav", NavSettings)
    assert str(refused.value) == f"{file}: {complaint}"
