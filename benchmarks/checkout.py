"""Another commit of this project, ready to run beside this checkout."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent.parent


class Ready(NamedTuple):
    """A checkout whose kernels are built."""

    folder: Path

    def command(self, *words: str) -> list[str]:
        """Return a command of Python; -P: modules of the current folder do not hide others."""
        return [sys.executable, "-P", *words]

    def environment(self) -> dict[str, str]:
        """Return its environment: its own modules, and what it keeps of kernels in its own folder."""
        return {**os.environ, "PYTHONPATH": str(self.folder), "ODS_CACHE_DIR": str(self.folder / "out" / "cache")}


@contextmanager
def checked_out(commit: str, folder: Path) -> Iterator[Path]:
    """Have a work tree of the commit in `folder` for a while."""
    git = ["git", "-C", str(HERE), "worktree"]
    subprocess.run([*git, "add", "--quiet", "--detach", str(folder), commit], check=True)
    try:
        yield folder
    finally:
        subprocess.run([*git, "remove", "--force", str(folder)], check=True)


def made_ready(checkout: Path) -> Ready:
    """Build the kernels of a checkout."""
    build = [sys.executable, "setup.py", "--quiet", "build_ext", "--inplace"]
    subprocess.run(build, cwd=checkout, check=True)
    return Ready(checkout)
