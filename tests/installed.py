"""The package as others get it: a wheel, installed in a virtual environment of its own."""

import shutil
import subprocess
import sys
import venv
from pathlib import Path

PROJECT = Path(__file__).parents[1]
INTO_A_WHEEL = ("ods", "config", "pyproject.toml", "README.md", "LICENSE")


def make_wheel(folder: Path) -> Path:
    """Build a wheel of a copy of the sources, in `folder`; nothing is fetched, nothing written beside the sources."""
    copy = folder / "source"
    copy.mkdir()
    for name in INTO_A_WHEEL:
        if (PROJECT / name).is_dir():
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(PROJECT / name, copy / name, symlinks=True, ignore=ignored)
        else:
            shutil.copy(PROJECT / name, copy)
    pip("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(copy))
    (wheel,) = folder.glob("*.whl")
    return wheel


def install(wheel: Path, environment: Path) -> Path:
    """Install the wheel in a new virtual environment that sees our dependencies, but not our sources.

    Returns its Python.
    """
    venv.create(environment, with_pip=False)
    python = environment / "bin" / "python"
    pip("--python", str(python), "install", "--no-deps", str(wheel))
    (packages,) = environment.glob("lib/python*/site-packages")
    ours = next(path for path in sys.path if path.endswith("site-packages"))
    (packages / "dependencies.pth").write_text(
        ours + "\n"
    )  # no .pth file of theirs is read, so not our editable install
    return python


def pip(*words: str) -> None:
    """Run pip quietly, without asking for a newer one."""
    command = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *words]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
