"""`python -m benchmarks.compile`: what the kernels cost to build: processor seconds, code and lines by folder.

`--against COMMIT` builds another commit's in the same run; one from before 0.5 has numba compile them.
"""

import argparse
import subprocess
import sys
import sysconfig
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks.checkout import HERE, checked_out, children_cpu_s, made_ready

KERNEL = "KERNEL"
"""In the name of each macro that declares a kernel (ods/compiled/kernel.h)."""


class Cost(NamedTuple):
    """What a folder's files took."""

    cpu_s: float = 0.0
    files: int = 0
    kernels: int = 0
    lines: int = 0
    code_kb: float = 0.0

    def plus(self, other: "Cost") -> "Cost":
        """Return both together."""
        return Cost(
            self.cpu_s + other.cpu_s, self.files + other.files, self.kernels + other.kernels,
            self.lines + other.lines, self.code_kb + other.code_kb,
        )  # fmt: skip


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--against", metavar="COMMIT", help="measure that commit, too")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="ods-compile-") as name:
        ours = _print_build(HERE, Path(name))
        if args.against:
            with checked_out(args.against, Path(name) / "other") as other:
                theirs = made_ready(other, Path(name) / "venv").build_cpu_s
            print(f"this checkout {ours:.1f} s, {args.against} {theirs:.1f} s: 1 / {theirs / ours:.1f}")


def _print_build(project: Path, scratch: Path) -> float:
    """Compile each file as `setup.py` does; print what it cost by folder and return the processor seconds of all."""
    flags = _flags(project)
    folders: dict[str, Cost] = defaultdict(Cost)
    for source in sorted((project / "ods").rglob("*.c")):
        folder = "/".join(source.parent.relative_to(project).parts[:3])
        folders[folder] = folders[folder].plus(_compiled(source, flags, scratch))
    print(f"{'folder':28}{'CPU s':>8}{'files':>7}{'kernels':>9}{'lines':>8}{'code kB':>9}")
    total = Cost()
    for folder, cost in sorted(folders.items(), key=lambda item: -item[1].cpu_s):
        total = total.plus(cost)
        print(_row(folder, cost))
    print(_row("all", total))
    return total.cpu_s


def _row(name: str, cost: Cost) -> str:
    return f"{name:28}{cost.cpu_s:8.2f}{cost.files:7}{cost.kernels:9}{cost.lines:8}{cost.code_kb:9.0f}"


def _flags(project: Path) -> list[str]:
    """Return the compiler and its options as `setup.py` gives them, told by a dry run of it."""
    code = (
        "import setuptools; setuptools.setup = lambda **_: None; import setup; print(*setup._native.extra_compile_args)"
    )
    told = subprocess.run([sys.executable, "-c", code], cwd=project, capture_output=True, text=True, check=True).stdout
    includes = [str(project), str(project / "ods" / "compiled"), np.get_include(), sysconfig.get_path("include")]
    return ["cc", "-fPIC", *told.split(), *(f"-I{folder}" for folder in includes)]


def _compiled(source: Path, flags: list[str], scratch: Path) -> Cost:
    target = scratch / "object.o"
    before = children_cpu_s()
    subprocess.run([*flags, "-c", str(source), "-o", str(target)], check=True, cwd=scratch)
    spent = children_cpu_s() - before
    text = source.read_text()
    kernels = sum(line.partition("(")[0].removeprefix("LONG_").startswith(KERNEL) for line in text.splitlines())
    told = subprocess.run(["size", str(target)], capture_output=True, text=True, check=True).stdout.splitlines()[1]
    return Cost(spent, 1, kernels, len(text.splitlines()), int(told.split()[0]) / 1000)


if __name__ == "__main__":
    main()
