"""`make benchmark`: CPU time of a scan against objects in view, with and without 10,000 hibernated ones.

Every tracker gets the same scans; all take turns within one run, so that a machine that slows down slows all of them.
`python -m benchmarks.tracker --out docs/assess/tracker-cost.png` draws the chart too; `--against COMMIT` compares the
scan step with that of another commit instead.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks.tracker.against import scan_steps
from benchmarks.tracker.fields import SETTLING, SIZES, TIMED, field
from ods.base.clock import NS
from ods.messages import Pose
from ods.plots.chart import number, save_figure, style_axes
from ods.plots.style import SERIES, STRONG, add_style, drawn_in
from ods.pose.buffer import PoseBuffer
from ods.tracker import scenario
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.measurement.pose import motion_during_reception
from ods.tracker.measurement.scan import Scan, echoes_of
from ods.tracker.named import TrackTables
from ods.tracker.observer.registry import OBSERVERS, make_observer
from ods.tracker.settings import MotionSettings, TrackerSettings
from ods.tracker.tracker import Tracker

TARGETS_MS = {10: 0.35, 100: 0.8, 300: 3.0}
HIBERNATED = 10_000
TIME_UPDATE_TARGET_MS = 0.1
TURN = 10
"""Scans of one tracker's turn."""
NEAREST_M, FARTHEST_M = 160.0, 3000.0
"""Where the hibernated objects lie: out of the sonar's reach."""


@dataclass
class Contestant:
    """A tracker and the scans that it is still to get."""

    name: str
    size: tuple[int, int]
    tracker: Tracker
    scans: Iterator[Scan]
    spent_ms: list[float]


def sleepers(count: int) -> list[MapObject]:
    """Return hibernated objects around, none in reach of the sonar."""
    rng = np.random.default_rng(0)
    distance, angle = np.sqrt(rng.uniform(NEAREST_M**2, FARTHEST_M**2, count)), rng.uniform(-np.pi, np.pi, count)
    north, east = (distance * np.cos(angle)).tolist(), (distance * np.sin(angle)).tolist()
    sigma = (0.1, 0.1, 2.0)
    return [MapObject(i + 1, (north[i], east[i], 4.0), sigma, 1.0, 0.1, 0.99, 50, 1, 2, 3) for i in range(count)]


def contestants() -> list[Contestant]:
    """Return every observer at every size, without and with hibernated objects."""
    found = []
    known = sleepers(HIBERNATED)
    for observer in OBSERVERS:
        for size in SIZES:
            scans = list(scenario.scans(field(*size).scenario))
            for asleep in (0, HIBERNATED):
                tracker = Tracker(TrackerSettings(observer=observer), known[:asleep], HIBERNATED + 1)
                name = f"{observer}, {asleep:,} hibernated" if asleep else observer
                found.append(Contestant(name, size, tracker, iter(scans), []))
    return found


def run(all_of_them: list[Contestant]) -> None:
    """Give every tracker its scans, in turns of some scans: as on board, where one tracker has the caches."""
    for _ in range(0, SETTLING + TIMED, TURN):
        for one in all_of_them:
            for scan in islice(one.scans, TURN):
                began = time.process_time()
                one.tracker.step(scan)
                one.spent_ms.append(1e3 * (time.process_time() - began))
    for one in all_of_them:
        del one.spent_ms[:SETTLING]


def measurements(count: int) -> PositionMeasurement:
    """Return so many, each of an object of its own."""
    ones = np.ones(count)
    noise = ones, ones, np.zeros(count), ones, ones, ones, ones
    level = np.zeros((2, count)), np.zeros((UNSEEN, 2, count)), np.zeros(2)
    return PositionMeasurement(np.ones((3, count)), *noise, *level)


def observer_steps() -> dict[str, list[float]]:
    """Return the median time, ms, of each observer by itself at each of SIZES: a ping that shows every object."""
    spent: dict[str, list[float]] = {name: [] for name in OBSERVERS}
    for count, _ in SIZES:
        measured, rows, since_s = measurements(count), np.arange(count), np.full(count, 1.0 / 7.0)
        step = partial(_ping, given=(rows, measured, since_s))
        for name, median in _in_turns(measured, step).items():
            spent[name].append(median)
    return spent


def _ping(observer: Any, given: tuple[Any, ...]) -> None:
    observer.predict(1.0 / 7.0)
    observer.belief_and_moments()
    observer.update(*given)


def time_updates() -> dict[str, float]:
    """Return the median time, ms, that each observer takes to carry 10,000 objects on."""
    return _in_turns(measurements(HIBERNATED), lambda observer: observer.predict(1.0 / 7.0))


def _in_turns(start: PositionMeasurement, step: Callable[[Any], None]) -> dict[str, float]:
    """Return the median time, ms, of a step of each observer, begun with these measurements."""
    observers = {name: make_observer(name, MotionSettings()) for name in OBSERVERS}
    spent: dict[str, list[float]] = {name: [] for name in observers}
    for observer in observers.values():
        TrackTables(observer.tables()).extend(len(start.radius))
        observer.start(start)
    for _ in range(TIMED):
        for name, observer in observers.items():
            began = time.process_time()
            step(observer)
            spent[name].append(1e3 * (time.process_time() - began))
    return {name: float(np.median(times)) for name, times in spent.items()}


def receptions() -> dict[int, float]:
    """Return the median time, ms, to map detections to the pose at transmission, three looks at poses of 100 Hz."""
    level, still, sigma = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.1, 0.1, 0.1)
    poses = PoseBuffer(400, 0.3)
    for k in range(400):
        poses.insert(Pose(k, k * NS // 100, 0, (0.02 * k, 0.0, 4.0), level, still, sigma, sigma))
    found = {}
    for _, detections in SIZES:
        echoes, _ = echoes_of(np.ones((detections, 7)) * np.linspace(1.0, 99.0, detections)[:, None])
        spent = []
        for turn in range(TIMED):
            began = time.process_time()
            sent = poses.at(2 * NS + 10_000 * turn)
            assert sent is not None
            listening = motion_during_reception.poses_of(sent, 100.0, 1500.0, poses.at)
            assert listening is not None
            motion_during_reception.at_transmission(echoes, listening)
            spent.append(1e3 * (time.process_time() - began))
        found[detections] = float(np.median(spent))
    return found


def draw(all_of_them: list[Contestant]) -> Figure:
    """Return the chart: medians as lines, crosses: targets."""
    figure = Figure(figsize=(8.5, 6.0), dpi=110, layout="constrained")
    axes = figure.subplots()
    observers = list(OBSERVERS)
    for name in dict.fromkeys(one.name for one in all_of_them):
        mine = [one for one in all_of_them if one.name == name]
        style = "s--" if "hibernated" in name else "o-"
        axes.plot([one.size[0] for one in mine], [float(np.median(one.spent_ms)) for one in mine], style, label=name,
                  color=SERIES[observers.index(name.partition(",")[0])])  # fmt: skip
    axes.plot(list(TARGETS_MS), list(TARGETS_MS.values()), "x", color=STRONG, ms=9, mew=2, label="target")
    axes.set_xscale("log")
    axes.set_yscale("log")
    number(axes.yaxis)
    axes.set_xticks([objects for objects, _ in SIZES], [f"{objects} x {found}" for objects, found in SIZES])
    axes.set_xticks([], minor=True)
    style_axes(axes, "a scan step, association included", "objects in view x detections", "CPU time, ms, median")
    return figure


def compare(commit: str) -> None:
    """Print the time of a scan step of the default tracker, of this checkout and of another commit."""
    found = scan_steps(commit, {size[0]: field(*size) for size in SIZES}, SETTLING)
    print(f"CPU time of a scan step, ms, median of {TIMED}, in turns")
    print(f"{'objects':>8}{'here':>10}{commit[:12]:>14}{'ratio':>8}")
    for objects, (here, there) in found.items():
        print(f"{objects:8}{here:10.3f}{there:14.3f}{here / there:8.2f}")


def main() -> None:
    """Print the table, draw the chart if wanted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, metavar="CHART.png")
    parser.add_argument("--against", metavar="COMMIT", help="only compare the scan step with that of another commit")
    add_style(parser)
    args = parser.parse_args()
    if args.against:
        compare(args.against)
        return
    all_of_them = contestants()
    run(all_of_them)
    print(f"\nCPU time of a scan step, ms, median of {TIMED}, in turns")
    print(f"{'observer':38}{'objects':>8}{'detections':>12}{'target':>8}{'ODS':>8}")
    for one in all_of_them:
        target = TARGETS_MS.get(one.size[0])
        cell = f"{target:8.2f}" if target else " " * 8
        print(f"{one.name:38}{one.size[0]:8}{one.size[1]:12}{cell}{np.median(one.spent_ms):8.3f}")
    print(f"\ntime update of {HIBERNATED:,} objects, ms (target {TIME_UPDATE_TARGET_MS})")
    for name, ms in time_updates().items():
        print(f"{name:38}{ms:8.3f}")
    print(f"\nobservers by themselves, a ping that shows {', '.join(str(size[0]) for size in SIZES)} objects, ms")
    for name, steps in observer_steps().items():
        print(f"{name:38}" + "".join(f"{ms:8.3f}" for ms in steps))
    print("\npose at transmission and reception, and the echoes mapped, ms")
    for detections, ms in receptions().items():
        print(f"{'detections':38}{detections:8}{ms:8.3f}")
    if args.out is not None:
        with drawn_in(args.style):
            save_figure(draw(all_of_them), args.out)
        print(f"drawn: {args.out}")


if __name__ == "__main__":
    main()
