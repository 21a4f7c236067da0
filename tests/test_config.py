"""A wrong configuration ends in one clear line that names the key, and exit code 2."""

import re
from pathlib import Path

import pytest

from ods.base.settings_file import ConfigError, load, load_table
from ods.bench.settings import BenchConfig
from ods.cli import main
from ods.config import OnboardConfig
from ods.pipeline.settings import PipelineSettings
from ods.tracker.settings import TrackerSettings

CONFIG = Path(__file__).parents[1] / "config"


def test_shipped_configurations_load() -> None:
    onboard = load(CONFIG / "onboard.toml", OnboardConfig)
    assert onboard.bus.run_dir.is_absolute()
    bench = load(CONFIG / "bench.toml", BenchConfig)
    assert bench.onboard == CONFIG / "onboard.toml"
    assert bench.sim.scene.is_file()
    assert bench.sim.sonar.is_file()
    assert load(CONFIG / "bench-vcan.toml", BenchConfig).sim.sonar.is_file()


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("[site]", "[site]\nlatitud_deg = 1.0", "site.latitud_deg: unknown key"),
        ("[bus]", "[bus]\nrun_dir = 7", "bus.run_dir: expected a string, got an integer"),
        ("latitude_deg = ", "latitude_deg = 900 #", "site.latitude_deg: must be at most 90 (degrees)"),
        ("latitude_deg = ", "latitude_deg = nan #", "site.latitude_deg: must be a finite number, got nan"),
        ("[site]", "[site", "not valid TOML"),
        (
            "[tracker.map]",
            '[tracker]\nobserver = "kalman"\n\n[tracker.map]',
            "'kalman' is not one of independent, coupled, manoeuvring",
        ),
        (
            "[tracker.map]",
            '[tracker]\nassociation = "best"\n\n[tracker.map]',
            "association: 'best' is not one of nearest, probabilistic",
        ),
        ('interface = "socketcan"', 'interface = "sockercan"', "virtual (did you mean socketcan)"),
        ("[nav.canopen]", '[nav]\nsource = "j1939"\n[nav.canopen]', "nav.source: 'j1939' is not one of canopen, dbc"),
        ("[sonar]\nport", "[sonar]\nprot", "sonar.prot: unknown key (did you mean port)"),
        (
            "[sonar]",
            '[sonar]\nprotocol = "s7"',
            "protocol: 's7' is not one of s7k, oculus, norbit, ping360, sonar3d15 (did you mean s7k)",
        ),
        ("[sonar]", "[sonar]\ngain = 3", "sonar.gain: unknown key (did you mean gain_db, in dB)"),
        ("[nav.can]", "[nav.limits]\nspeed = -1\n[nav.can]", "nav.limits.speed: must be more than 0 (m/s)"),
        ("[nav.can]", "[nav]\nstale_ms = 3\n[nav.can]", "nav.stale_ms: unknown key (did you mean stale_s, in seconds)"),
        ("[nav.can]", "[nav.nmea]\nheld.GGA.age = 3\n[nav.can]", "GGA.age: unknown key (did you mean max_age_s, in s"),
        (
            "[nav.can]",
            "[nav.nmea.accept]\nestimate = 3\n[nav.can]",
            "accept: 'estimate' is not one of estimated, manual, ",
        ),
        ("[nav.can]", "[nav.nmea.accept]\nmanual = -3\n[nav.can]", "accept.manual: must be at least 0 (metres)"),
        (
            "[nav.can]",
            "[nav]\nstale_s = '1 s'\n[nav.can]",
            "stale_s: expected a number, got a string; it is in seconds",
        ),
        ("[pipeline]", "[pipline]", "pipline: unknown key (did you mean pipeline)"),
        ("[pipeline]", '[[pipeline.stage]]\nuse = "filter.fri"', "stage[0].use: 'filter.fri' is not one of"),
        ("[pipeline]", '[[pipeline.stage]]\nuse = "detect.cfar"\nmethod = "so"', "(did you mean soca)"),
        ("[sonar]", "[sonar]\nbaud = -1", "sonar.baud: "),
        ("[tracker.map]", "[tracker]\ncolour = 1\n\n[tracker.map]", "tracker.colour: unknown key"),
        ("[nav.can]", '[nav.can]\nbitrate = "fast"', "nav.can.bitrate: expected an integer, got a string"),
        ("[sonar]", "[sonar]\nbaud = 115200.5", "sonar.baud: expected an integer, got a float"),
        (
            "[bus]",
            '[bus]\nkeys = "k"\nlisten = [{at = "tcp://127.0.0.1:1", topics = ["pose"]}, '
            '{at = "tcp://127.0.0.1:1", topics = ["ping"]}]',
            "bus.listen[1].at: tcp://127.0.0.1:1 has its [[bus.listen]] already: list all topics there",
        ),
        ("latitude_deg = ", "latitude_deg = [57, 2.88] #", "site.latitude_deg: expected a number, got a list"),
        ('interface = "socketcan"', 'interface = ""', "nav.can.interface: '' is not one of "),
        ("[nav.canopen]", '[nav]\nsource = ""\n[nav.canopen]', "nav.source: '' is not one of canopen, dbc, nmea"),
        ('port = "/dev/ttyUSB0"', 'port = ""', "sonar.port: must be a device or an address"),
        ('ins_eds = "ins.eds"', 'ins_eds = ""', "nav.canopen.ins_eds: must not be empty"),
        ('channel = "can0"', 'channel = "/dev/ttyUSB0"', "nav.can.channel: /dev/ttyUSB0 is the sonar's (sonar.port)"),
    ],
)
def test_wrong_key_type_or_range_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, complaint: str
) -> None:
    text = (CONFIG / "onboard.toml").read_text()
    assert old in text
    pattern = re.escape(old) + (r"[^\n]*" if old.endswith("= ") else "")
    file = tmp_path / "onboard.toml"
    file.write_text(re.sub(pattern, lambda _: new, text, count=1))
    with pytest.raises(ConfigError) as caught:
        load(file, OnboardConfig)
    assert complaint in str(caught.value)
    assert main(["run", "--config", str(file)]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    assert said[0].startswith("ods run: ")
    assert complaint in said[0]


def test_one_serial_line_is_not_of_two_devices(tmp_path: Path) -> None:
    file = tmp_path / "onboard.toml"
    file.write_text((CONFIG / "onboard-nmea.toml").read_text().replace("/dev/ttyUSB1", "/dev/ttyUSB0"))
    with pytest.raises(ConfigError, match=rf"{file}: nav\.nmea\.port: /dev/ttyUSB0 is the sonar's"):
        load(file, OnboardConfig)


def test_a_file_in_another_encoding_is_reported_by_its_line(tmp_path: Path) -> None:
    file = tmp_path / "onboard.toml"
    file.write_bytes("[bus]\n# Måløy\n".encode("latin-1"))
    with pytest.raises(ConfigError, match=rf"{file}: line 2 is not text in UTF-8"):
        load(file, OnboardConfig)


def test_pipeline_and_tracker_have_defaults_and_offline_commands_read_only_their_table(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    whole = (CONFIG / "onboard.toml").read_text()
    file.write_text(whole[: whole.index("[pipeline]")])
    config = load(file, OnboardConfig)
    assert (config.pipeline, config.tracker) == (PipelineSettings(), TrackerSettings())
    file.write_text("[pipeline]\nmin_range_m = 2.0\n[nav]\nsource = 7\n")
    assert load_table(file, "pipeline", PipelineSettings, OnboardConfig) == PipelineSettings(min_range_m=2.0)
    assert load_table(file, "tracker", TrackerSettings, OnboardConfig) == TrackerSettings()
    file.write_text("[pipelin]\nmin_range_m = 2.0\n")
    with pytest.raises(ConfigError, match=r"pipelin: unknown key \(did you mean pipeline\)"):
        load_table(file, "pipeline", PipelineSettings, OnboardConfig)


def test_a_stage_that_a_plug_in_may_bring_is_not_refused_at_load(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("")
    stage = ({"use": "my.stage"},)
    assert PipelineSettings(plugins=(tmp_path / "mine.py",), stage=stage).stage == stage
    with pytest.raises(ValueError, match="my"):
        PipelineSettings(stage=stage)


def test_missing_file_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sonar", "--config", str(tmp_path / "none.toml")]) == 2
    assert capsys.readouterr().err == f"ods sonar: {tmp_path / 'none.toml'}: No such file or directory\n"


def test_where_there_is_no_checkout_a_file_to_start_from_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["run"]) == 2
    said = "ods run: config/onboard.toml: No such file or directory: --config names yours; one to start from is "
    line = capsys.readouterr().err
    assert line.startswith(said)
    assert load(Path(line.removeprefix(said).strip()), OnboardConfig).sonar.port


@pytest.mark.parametrize("words", [["fly"], ["run", "--warp"], [], ["bench", "--seconds", "x"]])
def test_wrong_words_are_one_line_and_exit_code_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(words)
    assert caught.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


def test_relative_paths_are_taken_from_the_files_folder(tmp_path: Path) -> None:
    file = tmp_path / "deep" / "bench.toml"
    file.parent.mkdir()
    file.write_text((CONFIG / "bench.toml").read_text())
    assert load(file, BenchConfig).onboard == tmp_path / "deep" / "onboard.toml"
