"""What README, docs/architecture and docs/glossary.md say of the code is so: folders, layers, processes, names."""

import ast
import importlib
import re
import tomllib
from pathlib import Path

import pytest

from ods.reference.markdown import row
from ods.runtime.processes import PROCESSES

PROJECT = Path(__file__).parents[2]
PAGE = (PROJECT / "docs" / "architecture" / "README.md").read_text()
NAMED = r"`(ods/\S+\.py)` `([\w.]+)`"
STATIONS = re.findall(NAMED, PAGE)
GLOSSARY = (PROJECT / "docs" / "glossary.md").read_text()
WORDS = re.findall(r"^(.+?) \| .+ \| " + NAMED + r"$", GLOSSARY, re.MULTILINE)
NOT_OF_A_PACKAGE = {
    "browser",
    "data",
    "docs",
    "in_vcan",
    "install",
    "peers",
    "systemd",
    "vcan",
    "whole_chain",
    "upgrade",
}
"""Folders of tests that are not named after a folder of `ods`."""


def is_there(file: str, name: str) -> bool:
    """Tell whether a file defines a function or class of this name, which has the method behind the dot, if any."""
    outer, _, method = name.partition(".")
    if outer not in [getattr(node, "name", "") for node in ast.parse((PROJECT / file).read_text()).body]:
        return False
    module = importlib.import_module(file.removesuffix(".py").replace("/", "."))
    return not method or callable(getattr(getattr(module, outer), method, None))


def test_layers_are_those_of_the_import_contract() -> None:
    contracts = tomllib.loads((PROJECT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (layers,) = (contract["layers"] for contract in contracts if contract.get("exhaustive"))
    assert "".join(f"    {layer.replace(' | ', '  ')}\n" for layer in layers) in PAGE


def test_the_table_of_processes_is_the_process_table() -> None:
    def listed(names: tuple[str, ...]) -> str:
        return ", ".join(f"`{name}`" for name in names if name)

    rows = "".join(
        row(
            f"`{process.name}`", listed(process.reads), listed(process.publishes), listed((process.answers,)),
            f"`{process.worker.partition('.service:')[0].replace('.', '/')}/`",
        )
        for process in PROCESSES.values()
    )  # fmt: skip
    assert f"---|---|---|---|---\n{rows}\n" in PAGE


@pytest.mark.parametrize(("file", "name"), STATIONS)
def test_each_station_on_the_path_of_a_byte_is_there(file: str, name: str) -> None:
    assert is_there(file, name)


@pytest.mark.parametrize(("word", "file", "name"), WORDS)
def test_each_word_of_the_glossary_has_its_place(word: str, file: str, name: str) -> None:
    assert is_there(file, name)


def test_the_glossary_has_a_place_for_every_word() -> None:
    words = GLOSSARY[: GLOSSARY.index("## Words to replace")]
    rows = [line for line in words.splitlines() if " | " in line]
    assert len(WORDS) == len(rows) - rows.count("word | meaning | in the code") >= 30


def test_the_path_is_long_enough_to_be_one() -> None:
    assert len(STATIONS) > 25


def test_named_files_and_folders_exist() -> None:
    named = re.findall(r"`((?:ods|tests|benchmarks|in_vcan|config|deploy)/[\w/.]*)`", PAGE)
    assert [path for path in named if not (PROJECT / path).exists()] == []


def test_files_that_the_pages_name_exist() -> None:
    there = {
        path.name for folder in ("ods", "tests", "benchmarks", "docs") for path in (PROJECT / folder).rglob("*.py")
    }
    pages = [page for page in (PROJECT / "docs").rglob("*.md") if page.parent.name != "how-to"]  # they name new files
    pages += [PROJECT / "README.md", PROJECT / "CONTRIBUTING.md"]
    named = [(page.name, name) for page in pages for name in re.findall(r"`(?:[\w/]*/)?(\w+\.py)`", page.read_text())]
    assert len(named) > 50
    assert [(page, name) for page, name in named if name not in there and "NAME" not in name] == []


def test_tests_stand_in_folders_of_the_packages() -> None:
    tests = PROJECT / "tests"
    folders = {path.parent.relative_to(tests) for path in tests.rglob("test_*.py")}
    of_packages = [folder for folder in folders if folder.parts and not NOT_OF_A_PACKAGE & set(folder.parts)]
    assert [str(folder) for folder in of_packages if not (PROJECT / "ods" / folder / "__init__.py").exists()] == []
