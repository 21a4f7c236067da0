"""The command table: every row works, and nothing is imported for a command that was not chosen."""

import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from ods.cli import COMMANDS, Command, main


@pytest.mark.parametrize("row", COMMANDS, ids=lambda row: row.name)
def test_every_row_names_a_module_with_arguments_and_run(row: Command, capsys: pytest.CaptureFixture[str]) -> None:
    module = importlib.import_module(row.module)
    assert callable(module.run)
    with pytest.raises(SystemExit) as ended:
        main([*row.name.split(), "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert ended.value.code == 0
    assert row.help.capitalize() in said
    assert ("--config" in said) == (row.config != "")


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["map", "--help"]])
def test_help_imports_no_command(arguments: list[str]) -> None:
    told = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "ods", *arguments], capture_output=True, text=True, check=True
    )
    imported = {line.rpartition("|")[2].strip() for line in told.stderr.splitlines()}
    assert not imported & {row.module for row in COMMANDS}
    assert not imported & {"numpy", "numba", "zmq", "msgspec", "rich"}


@pytest.mark.parametrize("arguments", [[], ["map"], ["no-such-command"], ["map", "list", "--within", "1"]])
def test_a_wrong_use_is_one_line_and_exit_code_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("arguments", [["info", "tests/data/replay/figure11.mcap"], ["doctor"]])
def test_a_full_disk_behind_standard_output_is_one_line(arguments: list[str]) -> None:
    """Some commands print little, which Python writes at its end only, and says of it what nobody understands."""
    with Path("/dev/full").open("w") as full:
        told = subprocess.run(
            [sys.executable, "-m", "ods", *arguments], stdout=full, stderr=subprocess.PIPE, text=True, check=False,
            cwd=Path(__file__).parents[2],
        )  # fmt: skip
    assert told.stderr == f"ods {arguments[0]}: cannot write what it prints: no space left on device\n"
    assert told.returncode == 2
