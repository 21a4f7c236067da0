"""in_vcan as a distribution of its own."""

import subprocess
from pathlib import Path

import pytest

from tests.install.clean_venv import ROOT, bare, build_wheel, install

pytestmark = pytest.mark.slow


def test_it_builds_and_runs_without_this_project(tmp_path: Path) -> None:
    commands = install(build_wheel(ROOT / "in_vcan", tmp_path), "in-vcan", tmp_path / "venv")
    done = subprocess.run([str(commands / "in-vcan")], env=bare(), capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "which command?" in done.stderr
