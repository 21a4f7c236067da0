"""CPU time of the tracker's whole scan step, this checkout against another commit: `benchmarks.tracker --against`.

The other commit is checked out in a temporary folder. Each has a process and kernels of its own; both get the same
scenario files, by turns and on one processor, so that a machine that slows down slows both.
"""

import json
import subprocess
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.checkout import HERE, Ready, checked_out, made_ready
from ods.assess.track.case import Case, save_case

STEPS = Path(__file__).with_name("scan_steps.py")


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
