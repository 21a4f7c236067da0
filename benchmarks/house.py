"""`python -m benchmarks.house`: figures of how hard the code is to follow, none of which is met by cutting.

Hand-set constants a package: numbers in Python's modules and in the defaults of named tuples, and in C's defines; what
a user may set (`Settings`) is not counted. Walks: the files, Python and C, that the
work goes through, and how often it comes to one (stays) and comes back to one (returns), after a warm-up: of a ping
through the default chain, of a pose from its last CAN frame to the tracker, of a scan with objects and false alarms
through the tracker's step.
"""

import ast
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from itertools import islice, pairwise
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

from benchmarks.detection.speed import made_up_ping
from benchmarks.tracker.fields import SIZES, field
from ods.base.frames.mounting import MountingSettings
from ods.base.geodesy import SiteSettings
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseSettings
from ods.pose.utc import VehicleUtc
from ods.tracker import scenario
from ods.tracker.mission import MissionTracker
from ods.tracker.output.validity import InputMonitor
from ods.tracker.settings import TrackerConfig, TrackerSettings
from ods.tracker.tracker import Tracker
from tests.nav_bridge.canopen_samples import IDS, PERIOD, Bench, pdos

ROOT = Path(__file__).resolve().parents[1] / "ods"
DEFINED = re.compile(r"^#define [A-Z][A-Z0-9_]* +\(?-?[0-9]", re.MULTILINE)
KERNEL = re.compile(r"^(?:LONG_)?KERNEL(?:_[A-Z]+)?\(\s*(\w+)", re.MULTILINE)
WARM_UP = 30
"""Pings, epochs or scans before the one that is followed."""
SPACING_NS = 250_000
"""Between the frames of an epoch."""


def constants(path: Path) -> int:
    """Return how many numbers a file sets by hand."""
    text = path.read_text(encoding="utf-8")
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


class Walk(NamedTuple):
    """The files that a call goes through, in order, each as often as the work comes to it."""

    entered: list[Path]
    """By calls alone, as one reads."""
    passed: list[Path]
    """The ways back to the callers, too."""


def walk(work: Callable[[], object]) -> Walk:
    """Return the walk of a call."""
    entered: list[Path] = []
    files: list[Path] = []
    of_kernel = kernels()

    def note(frame: FrameType, event: str, argument: Any) -> None:
        file = Path(frame.f_code.co_filename)
        if event == "c_call" and argument.__name__ in of_kernel:
            entered.append(of_kernel[argument.__name__])
            files.append(of_kernel[argument.__name__])
        elif event in ("call", "return", "c_return") and file.is_relative_to(ROOT):
            files.append(file)
            entered.extend([file] if event == "call" else [])

    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
    return Walk(_stays(entered), _stays(files))


def _stays(files: list[Path]) -> list[Path]:
    return files[:1] + [here for before, here in pairwise(files) if here != before]


def walk_of_a_ping() -> Walk:
    """Return the walk of a ping through the default chain, 60 beams by 2000 samples."""
    chain, pings = Chain(PipelineSettings()), [made_up_ping(60, seed=seed) for seed in range(WARM_UP)]
    for ping in pings:
        chain.process(ping)
    return walk(lambda: chain.process(pings[-1]))


def walk_of_a_pose() -> Walk:
    """Return the walk of the CAN frame that completes an epoch, and of its pose in the tracker."""
    bench = Bench()
    config = TrackerConfig(SiteSettings(57.0, 9.9), PoseSettings(), TrackerSettings(), MountingSettings())
    tracker = MissionTracker(config, InputMonitor(0, (), lambda _: ""), VehicleUtc(0, 0, "clock"))
    for number in range(1, WARM_UP):
        for pose in bench.epoch(number):
            tracker.add_pose(pose)
    bench.epoch(WARM_UP, only=tuple(range(1, len(IDS))))

    def last() -> None:
        pose = bench.take(IDS[-1], pdos(WARM_UP)[-1], WARM_UP * PERIOD + len(IDS) * SPACING_NS)
        assert pose is not None
        tracker.add_pose(pose)

    return walk(last)


def walk_of_a_scan() -> Walk:
    """Return the walk of a scan through the tracker's step."""
    tracker, scans = Tracker(TrackerSettings()), scenario.scans(field(*SIZES[0]).scenario)
    for scan in islice(scans, WARM_UP):
        tracker.step(scan)
    scan = next(iter(scans))
    return walk(lambda: tracker.step(scan))


def main() -> None:
    """Print all; `--files`: those of each walk, in order."""
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
    print("\n| walk | files | stays | returns | stays with the ways back |\n|---|---|---|---|---|")
    for name, walked in {"ping": walk_of_a_ping, "pose": walk_of_a_pose, "scan": walk_of_a_scan}.items():
        entered, passed = walked()
        files = len(set(entered))
        print(f"| {name} | {files} | {len(entered)} | {len(entered) - files} | {len(passed)} |")
        if "--files" in sys.argv:
            print(*(path.relative_to(ROOT) for path in entered), sep="\n")


if __name__ == "__main__":
    main()
