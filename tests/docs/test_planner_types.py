"""A planner's author has types: mypy in strict mode reads the README's examples against the installed package."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.install.clean_venv import ROOT, build_wheel, install

pytestmark = pytest.mark.slow

EXAMPLES = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
SETTINGS = "[mypy]\nstrict = true\n[mypy-msgpack.*]\nignore_missing_imports = true\n"


@pytest.fixture(scope="module")
def python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Python of an environment with the wheel installed."""
    folder = tmp_path_factory.mktemp("planner")
    return install(build_wheel(ROOT, folder), "ods", folder / "venv") / "python"


def mypy(python: Path, folder: Path, *programs: str) -> str:
    """Return what mypy prints about programs in an empty folder."""
    (folder / "mypy.ini").write_text(SETTINGS)
    names = [f"planner_{number}.py" for number in range(len(programs))]
    for name, program in zip(names, programs, strict=True):
        (folder / name).write_text(program)
    command = [
        sys.executable,
        "-m",
        "mypy",
        "--python-executable",
        str(python),
        "--cache-dir",
        str(python.parent / "cache"),
    ]
    return subprocess.run([*command, *names], cwd=folder, env={}, capture_output=True, text=True).stdout


def test_readme_examples_pass_mypy_strict(python: Path, tmp_path: Path) -> None:
    assert len(EXAMPLES) == 4
    assert mypy(python, tmp_path, *EXAMPLES) == "Success: no issues found in 4 source files\n"


def test_a_wrong_field_is_found(python: Path, tmp_path: Path) -> None:
    wrong = EXAMPLES[0].replace("obstacle.position_ned", "obstacle.position")
    assert '"Obstacle" has no attribute "position"' in mypy(python, tmp_path, wrong)
