"""Each page of docs/how-to is followed to the letter in a copy of the project: files, changed lines, printed text."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROJECT = Path(__file__).parents[2]
PAGES = sorted(page for page in (PROJECT / "docs" / "how-to").glob("*.md") if page.name != "README.md")
NEW_FILE = re.compile(r"^(?:cp \S+|touch) (\S+)$", re.MULTILINE)
"""In a block of `sh`."""
BLOCK = re.compile(r"(?:^`(?P<path>\S+)`:\n\n)?^```(?P<kind>\w+)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    ignored = shutil.ignore_patterns("__pycache__")
    for folder in ("ods", "config", "deploy", "docs/examples"):
        shutil.copytree(PROJECT / folder, tmp_path / folder, symlinks=True, ignore=ignored)
    return tmp_path


def change(file: Path, diff: str) -> None:
    """Change the one place of a file that has the diff's old lines."""
    lines = diff.splitlines(keepends=True)
    old = "".join(line[1:] for line in lines if line[0] in " -")
    text = file.read_text()
    assert text.count(old) == 1, f"{file.name} has {text.count(old)} times:\n{old}"
    file.write_text(text.replace(old, "".join(line[1:] for line in lines if line[0] in " +")))


def output_of(program: str, copy: Path) -> str:
    environment = os.environ | {"PYTHONPATH": str(copy), "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", program], cwd=copy, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_a_page_can_be_followed(page: Path, copy: Path) -> None:
    path, printed, compared = "", "", 0
    for block in BLOCK.finditer(page.read_text()):
        path = block["path"] or path
        text = block["text"]
        match block["kind"], block["path"]:
            case "diff", _:
                change(copy / path, text)
            case "text", _:
                assert printed == text
                compared += 1
            case "python", None:
                printed = output_of(text, copy)
            case "sh", None:
                subprocess.run(["sh", "-e", "-c", text], cwd=copy, check=True)
            case "toml", None:
                tomllib.loads(text)
            case _:
                (copy / path).parent.mkdir(exist_ok=True)
                (copy / path).write_text(text)
    assert compared


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_new_files_are_written_as_all_others(page: Path, copy: Path) -> None:
    written = [block for block in BLOCK.finditer(page.read_text()) if block["path"] and block["kind"] == "python"]
    shutil.copy(PROJECT / "pyproject.toml", copy)
    for block in written:
        (copy / block["path"]).parent.mkdir(exist_ok=True)
        (copy / block["path"]).write_text(block["text"])
    for check in (["check"], ["format", "--check"]):
        files = [block["path"] for block in written]
        done = (
            subprocess.run([sys.executable, "-m", "ruff", *check, *files], cwd=copy, capture_output=True, text=True)
            if files
            else None
        )
        assert done is None or done.returncode == 0, done.stdout


def test_every_page_is_listed() -> None:
    listed = re.findall(r"\]\((\S+\.md)\) \|", (PROJECT / "docs" / "how-to" / "README.md").read_text())
    assert set(listed) == {page.name for page in PAGES} | {"../pipeline/user-stage.md"}


@pytest.mark.parametrize("page", PAGES, ids=[page.stem for page in PAGES])
def test_the_index_counts_the_files_of_ods_that_change(page: Path) -> None:
    blocks = list(BLOCK.finditer(page.read_text()))
    changed = {block["path"] for block in blocks if block["path"]}
    changed |= {path for block in blocks if block["kind"] == "sh" for path in NEW_FILE.findall(block["text"])}
    index = (PROJECT / "docs" / "how-to" / "README.md").read_text()
    (files,) = re.findall(rf"\]\({re.escape(page.name)}\) \| (\d+)", index)
    assert int(files) == len([path for path in changed if path.startswith("ods/")])
