"""`python -m benchmarks.house`: two figures of how hard the code is to follow, neither of which is met by cutting.

Hand-set constants a package: numbers in Python's modules and in the defaults of named tuples, and in C's defines; what
a user may set (`Settings`) and laws that a benchmark fitted are not counted. Files entered by one scan: what
`Tracker.step` runs through for a scan with objects and false alarms, Python and C, and how often the work goes from one
file to another.
"""

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterator
from itertools import islice, pairwise
from pathlib import Path
from types import FrameType
from typing import Any

from benchmarks.tracker import SIZES, field
from ods.tracker import scenario
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

ROOT = Path(__file__).resolve().parents[1] / "ods"
DEFINED = re.compile(r"^#define [A-Z][A-Z0-9_]* +\(?-?[0-9]", re.MULTILINE)
KERNEL = re.compile(r"^(?:LONG_)?KERNEL(?:_[A-Z]+)?\(\s*(\w+)", re.MULTILINE)
FITTED = ("laws.py",)
SCANS = 30
"""Before the one that is followed."""


def constants(path: Path) -> int:
    """Return how many numbers a file sets by hand."""
    text = path.read_text(encoding="utf-8")
    if path.name in FITTED:
        return 0
    if path.suffix in (".c", ".h"):
        return len(DEFINED.findall(text))
    found = 0
    for node in ast.parse(text).body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            found += _numbers(node.value)
        elif isinstance(node, ast.ClassDef) and any(ast.unparse(base) == "NamedTuple" for base in node.bases):
            found += sum(_numbers(each.value) for each in node.body if isinstance(each, ast.AnnAssign))
    return found


def _numbers(value: ast.expr | None) -> int:
    literals = [node.value for node in ast.walk(value) if isinstance(node, ast.Constant)] if value else []
    return sum(isinstance(number, int | float) and not isinstance(number, bool) for number in literals)


def sources(folder: Path) -> Iterator[Path]:
    """Yield the Python and C files below a folder."""
    for pattern in ("*.py", "*.c", "*.h"):
        yield from folder.rglob(pattern)


def kernels() -> dict[str, Path]:
    """Return the C file of each kernel."""
    return {name: path for path in ROOT.rglob("*.c") for name in KERNEL.findall(path.read_text(encoding="utf-8"))}


def files_of_a_scan() -> list[Path]:
    """Return the files that one scan goes through, in order: a file again each time the work comes back to it."""
    tracker, scans, files, of_kernel = (
        Tracker(TrackerSettings()),
        scenario.scans(field(*SIZES[0]).scenario),
        [],
        kernels(),
    )

    def note(frame: FrameType, event: str, argument: Any) -> None:
        file = Path(frame.f_code.co_filename)
        if event == "c_call" and argument.__name__ in of_kernel:
            files.append(of_kernel[argument.__name__])
        elif event in ("call", "return", "c_return") and file.is_relative_to(ROOT):
            files.append(file)

    for scan in islice(scans, SCANS):
        tracker.step(scan)
    scan = next(iter(scans))
    sys.setprofile(note)
    try:
        tracker.step(scan)
    finally:
        sys.setprofile(None)
    return files[:1] + [here for before, here in pairwise(files) if here != before]


def main() -> None:
    """Print both."""
    numbers: Counter[str] = Counter()
    lines: Counter[str] = Counter()
    for path in sources(ROOT):
        package = path.relative_to(ROOT).parts[0]
        numbers[package] += constants(path)
        lines[package] += len(path.read_text(encoding="utf-8").splitlines())
    print("| package | lines | hand-set constants |\n|---|---|---|")
    for package, count in numbers.most_common():
        if count:
            print(f"| {package} | {lines[package]} | {count} |")
    print(f"| all | {lines.total()} | {numbers.total()} |")
    stays = files_of_a_scan()
    print(f"\nfiles entered by one scan: {len(set(stays))}, in {len(stays)} stays")


if __name__ == "__main__":
    main()
