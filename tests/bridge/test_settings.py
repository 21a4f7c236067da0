"""Bad configuration of a bridge: one line that names file and key; none runs unless its table is given."""

import re
import subprocess
from pathlib import Path

import pytest

from ods.base.settings_file import ConfigError, load
from ods.bridge.settings import BridgeSettings
from ods.cli import main
from ods.config import OnboardConfig
from ods.runtime import supervisor
from ods.runtime.processes import PROCESSES

DEPLOY = Path(__file__).parents[2] / "deploy"
ONBOARD = Path(__file__).parents[2] / "config" / "onboard.toml"


def config(folder: Path, text: str) -> Path:
    (folder / "onboard.toml").write_text(ONBOARD.read_text() + text)
    return folder / "onboard.toml"


def test_none_runs_unless_its_table_is_given(tmp_path: Path) -> None:
    assert load(ONBOARD, OnboardConfig).bridge.given() == []
    file = config(tmp_path, '\n[bridge.moos]\nto = "udp://127.0.0.1:9300"\n[bridge.json]\nto = "udp://[::1]:5005"\n')
    assert load(file, OnboardConfig).bridge.given() == ["json", "moos"]
    assert [main(["bridge", name, "--is-on", "--config", str(file)]) for name in ("json", "ttm", "moos")] == [0, 1, 0]


@pytest.mark.parametrize(
    ("to", "said"),
    [
        ("udp://0.0.0.0:5005", "must be one receiver"),
        ("udp://[::]:5005", "must be one receiver"),
        ("udp://239.1.1.1:5005", "must be one receiver"),
        ("udp://[ff02::1]:5005", "must be one receiver"),
        ("udp://255.255.255.255:5005", "must be one receiver"),
        ("udp://planner:5005", "needs an IP address"),
        ("udp://[::1:5005", "needs an IP address"),
        ("udp://127.0.0.1:99999", "needs an IP address and a port"),
        ("udp://127.0.0.1", "expected an address and a port"),
        ("tcp://127.0.0.1:5005", "expected an address and a port"),
        ("127.0.0.1:5005", "needs an IP address"),
        ("", "needs an IP address"),
    ],
)
def test_a_destination_is_one_receiver(tmp_path: Path, to: str, said: str) -> None:
    file = config(tmp_path, f'\n[bridge.ttm]\nto = "{to}"\n')
    with pytest.raises(ConfigError) as refused:
        load(file, OnboardConfig)
    text = str(refused.value)
    assert text.startswith(f"{file}: bridge.ttm")
    assert f"to: {to}: {said}" in text
    assert "\n" not in text


def test_a_destination_must_be_given(tmp_path: Path) -> None:
    file = config(tmp_path, "\n[bridge.ttm]\nmost_hz = 1.0\n")
    with pytest.raises(ConfigError, match=r"bridge\.ttm\.to: missing"):
        load(file, OnboardConfig)


def test_a_bridge_without_its_table_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "onboard.toml"
    file.write_text(ONBOARD.read_text().replace("[bus]", f'[bus]\nrun_dir = "{tmp_path}"'))
    assert main(["bridge", "json", "--config", str(file)]) == 2
    assert capsys.readouterr().err == "ods bridge: bridge.json: missing: set `to`, the receiver's address\n"


def test_each_table_has_its_process_and_its_unit() -> None:
    names = [f"bridge_{name}" for name in BridgeSettings.__struct_fields__]
    assert names == [name for name in PROCESSES if name.startswith("bridge_")]
    (listing,) = re.findall(r"for bridge in \$\((.+)\); do", (DEPLOY / "install.sh").read_text())
    listed = subprocess.run(["sh", "-c", listing], cwd=DEPLOY.parent, capture_output=True, text=True, check=True)
    assert listed.stdout.split() == list(BridgeSettings.__struct_fields__)
    unit = (DEPLOY / "bridge.conf").read_text()
    assert "ExecCondition=/opt/ods/bin/ods bridge NAME --is-on --config" in unit
    assert "\nExecStart=\nExecStart=/opt/ods/bin/ods bridge NAME --config" in unit


def test_ods_run_starts_the_bridges_that_are_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[str] = []
    monkeypatch.setattr(supervisor, "supervise", lambda processes, *_: started.extend(each.name for each in processes))
    assert main(["run", "--config", str(ONBOARD)]) == 0
    assert not [name for name in started if name.startswith("bridge")]
    started.clear()
    assert main(["run", "--config", str(config(tmp_path, '\n[bridge.moos]\nto = "udp://127.0.0.1:9300"\n'))]) == 0
    assert started.count("bridge_moos") == 1
    command = supervisor._command(PROCESSES["bridge_moos"], Path("some.toml"), "info")
    assert command[3:] == ["ods", "bridge", "moos", "--config", "some.toml", "--log-level", "info"]
