"""A virtual environment with a wheel, what it needs and nothing else, made without a network."""

import os
import subprocess
import sys
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]


def build_wheel(source: Path, folder: Path) -> Path:
    """Build the wheel of a copy of `source`, files of git only, in `folder`."""
    copy = folder / "source"
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=source, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listed.split("\0")):
        if (source / name).is_file() and not (source / name).is_symlink():
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            (copy / name).write_bytes((source / name).read_bytes())
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "wheel", "--no-build-isolation"]
    subprocess.run([*pip, "--no-deps", "--no-index", "--wheel-dir", str(folder), str(copy)], check=True, env=bare())
    return next(folder.glob("*.whl"))


def install(wheel: Path, name: str, folder: Path) -> Path:
    """Install the wheel of distribution `name`, and links to what it requires; return the folder of its commands."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    python = folder / "bin" / "python"
    site = next(folder.glob("lib/python*/site-packages"))
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "--python", str(python), "install"]
    subprocess.run([*pip, "--no-deps", "--no-index", str(wheel)], check=True, env=bare())
    metadata = next(site.glob(f"{name.replace('-', '_')}-*.dist-info"))
    for needed in _closure(Distribution.at(metadata), {}).values():
        for file in needed.files or ():
            if file.parts[0] != "..":
                target = site / file.parts[0]
                if not target.exists():
                    target.symlink_to(Path(str(needed.locate_file(file.parts[0]))))
    return folder / "bin"


def _closure(wanted: Distribution, found: dict[str, Distribution]) -> dict[str, Distribution]:
    """Return the distributions that one requires, without extras, by name."""
    for line in wanted.requires or ():
        needed = Requirement(line)
        if needed.name not in found and (needed.marker is None or needed.marker.evaluate({"extra": ""})):
            found[needed.name] = distribution(needed.name)
            _closure(found[needed.name], found)
    return found


def bare(**more: str) -> dict[str, str]:
    """Return an environment in which nothing of the source tree is imported."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return kept | {"PYTHONSAFEPATH": "1"} | more
