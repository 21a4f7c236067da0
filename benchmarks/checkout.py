"""Another commit of this project, ready to run beside this checkout."""

import os
import resource
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
    python: Path
    """With all that it needs."""
    build_cpu_s: float
    """Processor seconds that its kernels took to build."""

    def command(self, *words: str) -> list[str]:
        """Return a command of its Python; -P: modules of the current folder do not hide others."""
        return [str(self.python), "-P", *words]

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


def made_ready(checkout: Path, venv: Path) -> Ready:
    """Build the kernels of a checkout.

    One from the time when numba compiled them gets an environment of its own in the folder `venv`.
    """
    if (checkout / "setup.py").exists():
        begun = children_cpu_s()
        build = [sys.executable, "setup.py", "--quiet", "build_ext", "--inplace"]
        subprocess.run(build, cwd=checkout, check=True)
        return Ready(checkout, Path(sys.executable), children_cpu_s() - begun)
    print(f"{checkout}: installing numba, compiling: minutes", file=sys.stderr)
    subprocess.run([sys.executable, "-m", "venv", str(venv)], check=True)
    pip = [str(venv / "bin" / "pip"), "install", "--quiet", "--disable-pip-version-check", "-c", "constraints.txt"]
    subprocess.run([*pip, ".[bench]"], cwd=checkout, check=True)
    ready = Ready(checkout, venv / "bin" / "python", 0.0)
    begun = children_cpu_s()
    quiet = subprocess.DEVNULL
    compile_all = ready.command("-m", "ods", "compile")
    subprocess.run(compile_all, cwd=checkout, env=ready.environment(), check=True, stdout=quiet)
    return ready._replace(build_cpu_s=children_cpu_s() - begun)


def children_cpu_s() -> float:
    """Return the processor seconds of all processes that this one has started and that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
