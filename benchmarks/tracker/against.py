"""CPU time of the tracker's whole scan step, this checkout against another commit: `benchmarks.tracker --against`.

The other commit is checked out in a temporary folder. Each has a process and kernels of its own; both get the same
scenario files, by turns and on one processor, so that a machine that slows down slows both.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from ods.assess.track.case import Case, save_case

HERE = Path(__file__).resolve().parents[2]
STEPS = Path(__file__).with_name("scan_steps.py")


class Ready(NamedTuple):
    """A checkout whose kernels are built."""

    folder: Path

    def command(self, *words: str) -> list[str]:
        """Return a command of Python; -P: modules of the current folder do not hide others."""
        return [sys.executable, "-P", *words]

    def environment(self) -> dict[str, str]:
        """Return its environment: its own modules, and what it keeps of kernels in its own folder."""
        return {**os.environ, "PYTHONPATH": str(self.folder), "ODS_CACHE_DIR": str(self.folder / "out" / "cache")}


def scan_steps(commit: str, cases: Mapping[int, Case], settling: int) -> dict[int, tuple[float, float]]:
    """Return the median times, ms, of this checkout and of `commit` for each of `cases`, after `settling` scans."""
    with TemporaryDirectory() as folder, checked_out(commit, Path(folder) / "ods") as other, ExitStack() as ends:
        files = []
        for size, case in cases.items():
            files.append(Path(folder) / f"{size}.npz")
            save_case(case, files[-1])
        ready = [made_ready(HERE), made_ready(other)]
        both = [ends.enter_context(_process(checkout, files)) for checkout in ready]
        found = {}
        for number, size in enumerate(cases):
            ours, theirs = _in_turns(both, number)
            found[size] = float(np.median(ours[settling:])), float(np.median(theirs[settling:]))
        return found


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


def _in_turns(both: list["subprocess.Popen[str]"], number: int) -> tuple[list[float], list[float]]:
    """Return the times of all scans of a file, of each process; they take turns, and in who comes first, too."""
    spent: tuple[list[float], list[float]] = [], []
    more, first = True, 0
    while more:
        for which in (first, 1 - first):
            times = _turn(both[which], number)
            spent[which].extend(times)
            more = bool(times)
        first = 1 - first
    return spent


def _turn(process: "subprocess.Popen[str]", number: int) -> list[float]:
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(f"{number}\n")
    process.stdin.flush()
    times: list[float] = json.loads(process.stdout.readline())
    return times


@contextmanager
def _process(ready: Ready, files: list[Path]) -> Iterator["subprocess.Popen[str]"]:
    """Run `scan_steps.py` with the `ods` of a checkout."""
    words, environment = ready.command(str(STEPS), *map(str, files)), ready.environment()
    pipe = subprocess.PIPE
    with subprocess.Popen(words, cwd=ready.folder, env=environment, stdin=pipe, stdout=pipe, text=True) as process:
        yield process
        assert process.stdin is not None
        process.stdin.close()
