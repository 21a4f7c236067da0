"""The same checks everywhere: `make lint`, before a commit, and on the code host."""

import os
import re
from pathlib import Path
from typing import Any

import yaml

PROJECT = Path(__file__).parents[2]


def read(name: str) -> Any:
    return yaml.safe_load((PROJECT / name).read_text())


def tool(command: str) -> str:
    """Return the command without options, as `ruff format` of `.venv/bin/ruff format --check`."""
    return " ".join(word for word in command.removeprefix(".venv/bin/").split() if not word.startswith("-"))


def test_hooks_before_a_commit_are_those_of_make_lint() -> None:
    (recipe,) = re.findall(r"^lint:.*\n((?:\t.*\n)+)", (PROJECT / "Makefile").read_text(), re.MULTILINE)
    linted = [tool(line.strip().removeprefix("$(BIN)/")) for line in recipe.splitlines()]
    (repository,) = read(".pre-commit-config.yaml")["repos"]
    assert repository["repo"] == "local"
    assert [tool(hook["entry"]) for hook in repository["hooks"]] == linted


def test_the_workflow_runs_what_ci_runs_and_keeps_its_log() -> None:
    steps = read(".github/workflows/ci.yml")["jobs"]["test"]["steps"]
    (checks,) = (step for step in steps if ".ci/run" in step.get("run", ""))
    command, log = checks["run"].split(" 2>&1 | tee ")
    assert checks["shell"] == "bash"  # the only shell there that fails with the first command of a pipe
    assert os.access(PROJECT / command, os.X_OK)
    assert log in [step.get("with", {}).get("path") for step in steps]
