"""The command table: every row works, and nothing is imported for a command that was not chosen."""

import importlib
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from ods.base.computer.memory import TOO_LITTLE
from ods.cli import COMMANDS, Command, main
from tests.locked_folder import lock


@pytest.mark.parametrize("row", COMMANDS, ids=lambda row: row.name)
def test_every_row_names_a_module_with_arguments_and_run(row: Command, capsys: pytest.CaptureFixture[str]) -> None:
    module = importlib.import_module(row.module)
    assert callable(module.run)
    with pytest.raises(SystemExit) as ended:
        main([*row.name.split(), "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert ended.value.code == 0
    assert row.help[0].upper() + row.help[1:] in said, "names keep their capitals"
    assert ("--config" in said) == (row.config != "")


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["map", "--help"]])
def test_help_imports_no_command(arguments: list[str]) -> None:
    reported = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "ods", *arguments], capture_output=True, text=True, check=True
    )
    imported = {line.rpartition("|")[2].strip() for line in reported.stderr.splitlines()}
    assert not imported & {row.module for row in COMMANDS}
    assert not imported & {"numpy", "zmq", "msgspec", "rich"}


@pytest.mark.parametrize(
    "arguments",
    [
        ["track", "nowhere.npz"],
        ["detect", "nowhere.npz"],
        ["calibrate", "nowhere.npz"],
        ["simulate", "nowhere.toml", "--out", "x.npz"],
        ["assess", "sea", "--scene", "nowhere.toml"],
        ["assess", "track", "--scene", "nowhere.toml"],
        ["assess", "detect", "--own", "--scene", "nowhere.toml"],
        ["bench", "--config", "nowhere.toml"],
    ],
    ids=" ".join,
)
def test_a_file_that_is_not_there_is_missed_before_anything_slow_is_imported(arguments: list[str]) -> None:
    reported = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "ods", *arguments], capture_output=True, text=True, check=False
    )
    lines = reported.stderr.splitlines()
    imported = {line.rpartition("|")[2].strip() for line in lines if line.startswith("import time:")}
    assert reported.returncode == 2
    assert "No such file or directory" in lines[-1]
    assert not imported & {"matplotlib", "numpy", "ods.compiled.native", "ods.sim_sonar", "rich", "scipy"}


WITHOUT_KERNELS = """
import sys
import ods.compiled
ods.compiled.__path__ = [sys.argv.pop(1)]
from ods.cli import main
sys.exit(main(sys.argv[1:]))
"""
"""The command, with kernels looked for in another folder."""


@pytest.mark.parametrize(
    "arguments", [["detect", "tests/data/aris/sample.aris"], ["pipeline"], ["tracker"], ["doctor"]]
)
@pytest.mark.parametrize(
    ("built", "why"),
    [(None, "the kernels are not built: run `make kernels`"), ("for another processor", "cannot load the kernels: ")],
    ids=["not built", "not for here"],
)
def test_kernels_that_cannot_be_loaded_are_one_line(
    arguments: list[str], built: str | None, why: str, tmp_path: Path
) -> None:
    if built is not None:
        (tmp_path / "native.abi3.so").write_text(built)
    reported = subprocess.run(
        [sys.executable, "-c", WITHOUT_KERNELS, str(tmp_path), *arguments], capture_output=True, text=True, check=False
    )
    assert reported.returncode == 2
    assert reported.stderr.startswith(f"ods {arguments[0]}: {why}")
    assert reported.stderr.count("\n") == 1


@pytest.mark.parametrize("arguments", [[], ["map"], ["no-such-command"], ["map", "list", "--within", "1"]])
def test_a_wrong_use_is_one_line_and_exit_code_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ["map", "list", "PLACE"],
        ["simulate", "PLACE"],
        ["workbench", "PLACE"],
        ["assess", "sea", "--scene", "PLACE"],
        ["assess", "detect", "--real", "PLACE", "PLACE"],
        ["detect", "tests/data/aris/sample.aris", "--quiet", "--out", "PLACE"],
    ],
)
def test_a_path_that_no_file_can_have_is_one_line(
    arguments: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    loop = tmp_path / "loop.toml"
    loop.symlink_to(loop)
    for place, why in ((tmp_path / ("x" * 300), "file name too long"), (loop, "too many levels of symbolic links")):
        assert main([str(place) if word == "PLACE" else word for word in arguments]) == 2
        assert capsys.readouterr().err == f"ods {arguments[0]}: {place}: {why}\n"


def test_a_folder_that_may_not_be_looked_into_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    place = tmp_path / "locked" / "map.sqlite"
    lock(monkeypatch, place.parent)
    assert main(["map", "list", str(place)]) == 2
    assert capsys.readouterr().err == f"ods map: {place}: permission denied\n"
    config = tmp_path / "config.toml"
    config.write_text(f"[tracker.map]\npath = '{place}'\n")
    for action in (["list"], ["prune", "--seen-fewer", "2"]):
        assert main(["map", *action, "--config", str(config)]) == 2
        assert capsys.readouterr().err == f"ods map: map {place}: permission denied\n"


@pytest.mark.parametrize("arguments", [["info", "tests/data/replay/figure11.mcap"], ["doctor"]])
def test_a_full_disk_behind_standard_output_is_one_line(arguments: list[str]) -> None:
    """Some commands print little, which Python writes at its end only, and says of it what nobody understands."""
    with Path("/dev/full").open("w") as full:
        reported = subprocess.run(
            [sys.executable, "-m", "ods", *arguments], stdout=full, stderr=subprocess.PIPE, text=True, check=False,
            cwd=Path(__file__).parents[2],
        )  # fmt: skip
    assert reported.stderr == f"ods {arguments[0]}: cannot write its output: no space left on device\n"
    assert reported.returncode == 2


def test_an_error_that_cannot_be_written_has_its_exit_code(tmp_path: Path) -> None:
    """The log of `ods run` on a full disk."""
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "ods", "run", "--config", str(tmp_path / "none.toml")]
        assert subprocess.run(command, stdout=full, stderr=full, check=False).returncode == 2


@pytest.mark.parametrize("command", ["run", "record", "doctor", "map list"])
def test_too_few_open_files_are_one_line(command: str) -> None:
    """ZeroMQ would end the process, and Python with a traceback, wherever the last one is wanted."""
    reported = subprocess.run(
        ["sh", "-c", f"ulimit -n 14; exec {shlex.quote(sys.executable)} -m ods {command}"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    name = command.partition(" ")[0]
    assert reported.stderr == f"ods {name}: the limit of open files is 14: at least 64 are needed, see `ulimit -n`\n"
    assert reported.returncode == 2


def test_a_low_limit_that_may_be_raised_is_raised() -> None:
    code = "import resource; from ods.base.computer.open_files import *; allow_enough(); print(*resource.getrlimit(7))"
    reported = subprocess.run(
        ["sh", "-c", f"ulimit -n 512; ulimit -S -n 14; exec {shlex.quote(sys.executable)} -c '{code}'"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert reported.stdout == "512 512\n"


@pytest.mark.parametrize("command", ["run", "watch --once", "doctor", "map list"])
def test_a_name_beyond_the_locale_is_one_line(command: str, tmp_path: Path) -> None:
    file = tmp_path / "onboard.toml"
    text = (Path(__file__).parents[2] / "config" / "onboard-nmea.toml").read_text()
    text = text.replace("[bus]", f'[bus]\nrun_dir = "{tmp_path}/fährte"')
    file.write_text(text.replace("~/", f"{tmp_path}/fährte/"), encoding="utf-8")
    reported = subprocess.run(
        [sys.executable, "-m", "ods", *command.split(), "--config", str(file)],
        env=os.environ | {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
        capture_output=True, text=True, check=False, timeout=60.0,
    )  # fmt: skip
    assert reported.returncode == 2
    assert "Traceback" not in reported.stderr
    last = reported.stderr.splitlines()[-1]
    assert "set one of UTF-8, such as LC_ALL=C.UTF-8" in last or "no such file" in last


def test_a_home_that_cannot_be_written_is_no_trouble_of_pictures(tmp_path: Path) -> None:
    """Matplotlib warned of it, as a user without a home folder saw it, in two lines before every other one."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("XDG_", "MPL"))}
    reported = subprocess.run(
        [sys.executable, "-m", "ods", "track", str(tmp_path / "absent.npz")],
        env=environment | {"HOME": "/proc/none"}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert reported.returncode == 2
    assert "atplotlib" not in reported.stderr


def test_ctrl_c_while_a_command_is_imported_says_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(_module: str) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("ods.cli.importlib.import_module", interrupted)
    assert main(["info", "mission.mcap"]) == 130
    assert capsys.readouterr() == ("", "")


def test_too_little_memory_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def import_module(_module: str) -> None:
        try:
            raise OSError("libscipy_openblas.so: failed to map segment from shared object")
        except OSError:
            raise OSError("Could not find/load shared object file 'libscipy_openblas.so'")  # noqa: B904 (as libraries do)

    monkeypatch.setattr("ods.cli.importlib.import_module", import_module)
    assert main(["info", "mission.mcap"]) == 2
    assert capsys.readouterr().err == f"ods: {TOO_LITTLE}\n"


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one processor: there is one thread anyway")
def test_products_of_matrices_take_one_thread() -> None:
    """Threads that wait for each other cost pings 2 ms where four processes share two cores."""
    code = (
        "import os, ods.cli; ods.cli.main(['info', 'nothing.mcap']); import numpy as np;"
        "a = np.ones((500, 500)); a @ a; print(len(os.listdir('/proc/self/task')))"
    )
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    reported = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert reported.stdout == "1\n"
