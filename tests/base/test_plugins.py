"""Plug-ins of every kind: files, modules, entry points, what is wrong with one, and who may have written it."""

import os
import sys
from collections import Counter
from pathlib import Path

import pytest

from ods.base import plugins
from ods.base.plugins import PluginError, PluginGroup, add
from ods.base.settings_file import ConfigError, load_table
from ods.sonar_link.registry import make_protocol
from ods.sonar_link.settings import SonarSettings
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

pytestmark = pytest.mark.usefixtures("registers")
GROUP = PluginGroup("tracker.plugins", "ods.tracker")


def written(file: Path, code: str) -> Path:
    file.write_text(code)
    return file


def test_a_module_is_imported_by_its_name_whatever_folder_the_settings_put_before_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "odd_package").mkdir()
    written(tmp_path / "odd_package" / "__init__.py", "")
    written(tmp_path / "odd_package" / "parts.py", "loaded = True")
    monkeypatch.syspath_prepend(tmp_path)
    written(tmp_path / "onboard.toml", '[tracker]\nplugins = ["odd_package.parts"]\nobserver = "odd"')
    settings = load_table(tmp_path / "onboard.toml", "tracker", TrackerSettings)
    GROUP.load(settings.plugins)
    assert sys.modules["odd_package.parts"].loaded
    with pytest.raises(PluginError, match=r"tracker\.plugins\[0\] \(no_such\.module\): ModuleNotFoundError"):
        GROUP.load([tmp_path / "no_such.module"])


def test_a_file_runs_once_and_one_that_ends_the_process_is_an_error(tmp_path: Path) -> None:
    count = "import os\nos.environ['PLUGIN_RUNS'] = os.environ.get('PLUGIN_RUNS', '') + 'x'\n"
    file = written(tmp_path / "once.py", count)
    GROUP.load([file, file])
    GROUP.load([file])
    assert os.environ.pop("PLUGIN_RUNS") == "x"
    with pytest.raises(PluginError, match="SystemExit"):
        GROUP.load([written(tmp_path / "ends.py", "raise SystemExit(0)")])


def test_an_entry_point_that_fails_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    class Entry:
        name = "mine"

        def load(self) -> None:
            raise ImportError("gone")

    monkeypatch.setattr(plugins, "installed", lambda group: [Entry()])
    with pytest.raises(PluginError, match=r"^entry point ods\.tracker mine: ImportError: gone$"):
        GROUP.load([])


def test_a_name_is_given_once() -> None:
    register: dict[str, object] = {"print": print}
    add(register, "part", "print", print)
    with pytest.raises(PluginError, match=r"part print: the name is already taken by builtins\.print"):
        add(register, "part", "print", input)


@pytest.mark.parametrize("what", ["file", "folder"])
@pytest.mark.parametrize("who", ["root or a service account", "systemd", "a user"])
def test_root_and_services_run_nothing_that_others_can_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str, who: str
) -> None:
    monkeypatch.setattr(plugins, "LEAST_LOGIN_UID", os.getuid() + (who == "root or a service account"))
    monkeypatch.setenv("SYSTEMD_EXEC_PID", str(os.getpid()) if who == "systemd" else "1")
    monkeypatch.setattr(os, "getppid", lambda: 99)
    folder = tmp_path / "plugins"
    folder.mkdir()
    file = written(folder / f"{what}.py", "")
    GROUP.load([file])
    sys.modules.pop(f"ods_plugin:{file}")
    place = file if what == "file" else folder
    place.chmod(0o775)
    if who == "a user":
        GROUP.load([file])
        return
    with pytest.raises(PluginError) as caught:
        GROUP.load([file])
    assert str(caught.value).startswith(f"tracker.plugins[0] ({file}): {place} can be written by others (chmod go-w)")
    assert f"ods_plugin:{file}" not in sys.modules


@pytest.mark.parametrize("key", ["observer", "association"])
def test_a_name_that_no_plugin_has_is_known_when_they_are_loaded(tmp_path: Path, key: str) -> None:
    written(tmp_path / "empty.py", "")
    file = written(tmp_path / "onboard.toml", f'[tracker]\nplugins = ["empty.py"]\n{key} = "nobodys"')
    settings = load_table(file, "tracker", TrackerSettings)
    with pytest.raises(PluginError, match=rf"^tracker\.{key}: 'nobodys' is not one of "):
        Tracker(settings)
    written(file, f'[tracker]\n{key} = "nobodys"')
    with pytest.raises(ConfigError, match=rf"tracker\.{key}: 'nobodys' is not one of "):
        load_table(file, "tracker", TrackerSettings)


def test_what_a_plugged_in_sonar_cannot_do_is_said_when_it_is_loaded(tmp_path: Path) -> None:
    code = (Path("docs") / "examples" / "user_sonar.py").read_text().replace('"sketch"', '"test.sketch"')
    file = written(tmp_path / "sonar.py", code)

    def complaint(text: str) -> str:
        toml = written(tmp_path / "onboard.toml", f'[sonar]\nplugins = ["sonar.py"]\n{text}')
        with pytest.raises((PluginError, ConfigError)) as caught:
            make_protocol(load_table(toml, "sonar", SonarSettings), Counter())
        return str(caught.value)

    good = SonarSettings(plugins=(file,), protocol="test.sketch", port="/dev/ttyUSB0")
    assert type(make_protocol(good, Counter())).__name__ == "SketchProtocol"
    assert complaint('protocol = "test.sketch"\nport = "tcp://10.0.0.5:1"') == (
        f"{tmp_path}/onboard.toml: sonar.port: tcp://10.0.0.5:1: test.sketch works over serial, socket only: "
        "write /dev/DEVICE or socket://HOST:PORT"
    )
    assert complaint('protocol = "sketched"\nport = "/dev/x"').startswith(
        "sonar.protocol: 'sketched' is not one of s7k"
    )
    assert "gain_db: test.sketch has its own settings" in complaint(
        'protocol = "test.sketch"\nport = "/dev/x"\ngain_db = 3.0'
    )
