"""`benchmarks.processes.soak --minutes 60 --seed 0`: the bench with faults at random times, judged by the truth.

Real processes, a vehicle on a circle among eight spheres, and about every 20 s a fault: a process killed or stopped,
bytes that are no pings, silence, an INS that steps, beams or images that blind, loud spells. Printed is each valid list
that was wrong for longer than `TOLERATED_S` (an object in sight that it does not have, or an active obstacle where
there is none), with the fault before it, and how memory and descriptors of each process grew. Exit status 1 where
anything is printed as wrong or grew.
"""

import argparse
import json
import math
import sys
import tempfile
import threading
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
import psutil
import tomli_w

from ods.base.clock import NS
from ods.base.settings_file import load
from ods.bench.runner import fly_mission
from ods.bench.settings import BenchConfig, KillSettings
from ods.messages import Obstacle, ObstacleList, Truth, TruthObject
from ods.offline.run_record import RunRecord
from ods.offline.score import STANDS_FOR_M, match
from ods.runtime.bus import BusSettings
from ods.sim_sonar.settings import INS_STEP_M, FaultSettings

CONFIG = Path("config/bench.toml")
TOLERATED_S, SETTLE_S = 2.0, 5.0
"""A valid list may be wrong for so long; an object has so long, in sight, to be confirmed."""
GROWTH_MB, WARM_S = 2.0, 120.0
"""No process may grow by more, after so long."""
EVERY_S = 20.0
LAP_S, CIRCLE_M = 300.0, 50.0
DEVICE_FAULTS = ("serial_unplugged", "sonar_silent", "sonar_garbage", "ins_silent", "ins_steps", "zeros", "dead_beams",
                 "cut_beams", "head_blocked", "saturated")  # fmt: skip
PROCESSES = ("sonar", "pipeline", "tracker", "nav")


class Happened(NamedTuple):
    """A fault, in mission time."""

    what: str
    from_s: float
    to_s: float


def draw(minutes: float, seed: int) -> list[Happened]:
    """Return what happens when; the same for the same seed."""
    rng = np.random.default_rng(seed)
    found, at_s = list[Happened](), 30.0
    while at_s < 60.0 * minutes - 15.0:
        kind = str(rng.choice((*DEVICE_FAULTS, "kill", "stop", "loud")))
        if kind in ("kill", "stop"):
            found.append(Happened(f"{kind} {rng.choice(PROCESSES)}", at_s, at_s))
        else:
            found.append(Happened(kind, at_s, at_s + float(rng.uniform(1.0, 8.0))))
        at_s += float(rng.uniform(0.6, 1.4)) * EVERY_S
    return found


def scene_of(happened: list[Happened], minutes: float, seed: int) -> dict[str, Any]:
    """Return the scene's tables."""
    times = np.arange(-10.0, 60.0 * minutes + 30.0, 10.0)
    turned = 2.0 * np.pi * times / LAP_S
    waypoints = [
        {"t_s": float(t), "position_ned": [CIRCLE_M * math.cos(a), CIRCLE_M * math.sin(a), 20.0]}
        for t, a in zip(times, turned, strict=True)
    ]
    objects = [
        {
            "shape": "sphere", "name": f"sphere {k}", "radius_m": 1.5,
            "position_ned": [r * math.cos(a), r * math.sin(a), 20.5],
            "surface": {"cd": 0.1, "cs": 0.05, "sigma_deg": 15.0},
        }
        for k, (r, a) in enumerate((CIRCLE_M + (12.0 if k % 2 else -14.0), 2.0 * math.pi * k / 8) for k in range(8))
    ]  # fmt: skip
    loud = [
        {"level_counts": 1000.0, "from_s": each.from_s, "to_s": each.to_s} for each in happened if each.what == "loud"
    ]
    return {
        "seed": seed, "duration_s": 60.0 * minutes, "vehicle": {"waypoints": waypoints, "follow_path": True},
        "objects": objects, "image": {"loud_spells": loud},
        "sea_bed": {"depth_m": 26.0, "surface": {"cd": 0.5, "cs": 0.2, "sigma_deg": 20.0}},
    }  # fmt: skip


def settings_of(folder: Path, happened: list[Happened], minutes: float, seed: int) -> BenchConfig:
    """Return the bench with all that happens."""
    scene = folder / "scene.toml"
    scene.write_text(tomli_w.dumps(scene_of(happened, minutes, seed)))
    shipped = load(CONFIG, BenchConfig)
    faults = [
        FaultSettings(each.what, each.from_s, each.to_s - each.from_s)  # type: ignore[arg-type]
        for each in happened
        if each.what in DEVICE_FAULTS
    ]
    kills = [
        KillSettings(each.what.split()[1], each.from_s, each.what.split()[0].upper())  # type: ignore[arg-type]
        for each in happened
        if each.what.startswith(("kill", "stop"))
    ]
    return msgspec.structs.replace(
        shipped, bus=BusSettings(run_dir=folder / "run"), out=folder / "out", seconds=60.0 * minutes, kill=kills,
        sim=msgspec.structs.replace(shipped.sim, scene=scene, fault=faults),
    )  # fmt: skip


class Descriptors(threading.Thread):
    """Counts the open descriptors of all processes below this one, by their `ods` command."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.counts: dict[tuple[str, int], list[int]] = defaultdict(list)
        self._ends = threading.Event()

    def run(self) -> None:
        """Count every few seconds."""
        while not self._ends.wait(10.0):
            for child in psutil.Process().children(recursive=True):
                try:
                    words = child.cmdline()
                    if "ods" in words:
                        self.counts[words[words.index("ods") + 1], child.pid].append(child.num_fds())
                except psutil.Error:
                    continue

    def end(self) -> None:
        """Count no more."""
        self._ends.set()
        self.join()


def wrong_in(record: RunRecord, happened: list[Happened]) -> Iterator[tuple[float, set[str]]]:
    """Yield the mission time of each list that is a ping's, and what is wrong with it; not valid: nothing."""
    begun_ns = min(truth.t_ns for truth in record.truths.values())
    in_sight_since: dict[str, float] = {}
    for _, message in record.lists:
        truth = record.truths.get(message.ping_number)
        if truth is None:
            continue
        t_s = (truth.t_ns - begun_ns) / NS
        stepped = any(each.what == "ins_steps" and each.from_s <= t_s < each.to_s for each in happened)
        shown = _shifted(truth) if stepped else truth
        in_sight_since = {
            target.name: in_sight_since.get(target.name, t_s) for target in shown.objects if target.in_sector
        }
        yield t_s, _wrong(message, shown, {n for n, since_s in in_sight_since.items() if t_s - since_s > SETTLE_S})


def _shifted(truth: Truth) -> Truth:
    """Return what is true for an INS that steps."""

    def moved(place: tuple[float, float, float]) -> tuple[float, float, float]:
        north, east, down = (a + b for a, b in zip(place, INS_STEP_M, strict=True))
        return north, east, down

    objects = [msgspec.structs.replace(each, position_ned=moved(each.position_ned)) for each in truth.objects]
    return msgspec.structs.replace(truth, position_ned=moved(truth.position_ned), objects=objects)


def _wrong(message: ObstacleList, truth: Truth, expected: set[str]) -> set[str]:
    if not message.valid:
        return set()
    held = [each for each in message.obstacles if each.state in ("active", "stand_by", "hibernated")]
    found = match(truth, held)
    missed = {
        f"no {target.name}"
        for target in truth.objects
        if target.name in expected and target.name not in found and not _is_unseen(target, truth, message)
    }
    return missed | {f"ghost {each.id}" for each in held if each.state == "active" and not _stands(each, truth)}


def _stands(obstacle: Obstacle, truth: Truth) -> bool:
    return any(
        math.dist(obstacle.position_ned[:2], each.position_ned[:2]) < STANDS_FOR_M + each.radius_m
        for each in truth.objects
    )


def _is_unseen(target: TruthObject, truth: Truth, message: ObstacleList) -> bool:
    w, x, y, z = truth.attitude
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    north, east = (a - b for a, b in zip(target.position_ned[:2], truth.position_ned[:2], strict=True))
    bearing = (math.atan2(east, north) - yaw + math.pi) % (2.0 * math.pi) - math.pi
    range_m, margin_rad = math.hypot(north, east), math.radians(3.0)
    return any(
        part.bearing_min_rad - margin_rad <= bearing <= part.bearing_max_rad + margin_rad
        and part.range_min_m - 3.0 <= range_m <= part.range_max_m + 3.0
        for part in message.unseen
    )


def spells(record: RunRecord, happened: list[Happened]) -> Iterator[tuple[str, float, float]]:
    """Yield what was wrong in valid lists, from when to when, of spells longer than is tolerated."""
    begun: dict[str, float] = {}
    before_s = 0.0
    for t_s, wrong in [*wrong_in(record, happened), (math.inf, set())]:
        for what in begun.keys() - wrong:
            if before_s - begun[what] > TOLERATED_S:
                yield what, begun[what], before_s
        begun = {what: begun.get(what, t_s) for what in wrong}
        before_s = t_s


def cause_of(t_s: float, happened: list[Happened]) -> str:
    """Return the fault that is on, or was last, and how long ago."""
    before = [each for each in happened if each.from_s <= t_s]
    if not before:
        return "no fault yet"
    last = before[-1]
    return f"{last.what}, {'on' if t_s <= last.to_s else f'{t_s - last.to_s:.0f} s over'}"


def growth(record: RunRecord, descriptors: Descriptors) -> Iterator[tuple[str, float, int]]:
    """Yield process, growth in MB and in descriptors, of each that ran for long."""
    for name, reports in record.health.items():
        for pid in sorted({report.pid for report in reports if report.pid}):
            mine = [report for report in reports if report.pid == pid]
            settled = [each.rss_mb for each in mine if each.t_ns - mine[0].t_ns > WARM_S * NS]
            if len(settled) > 60:
                counts = descriptors.counts.get((name, pid), [0])
                few = min(10, len(counts))
                grown = float(np.median(settled[-30:]) - np.median(settled[:30]))
                yield name, grown, round(float(np.median(counts[-few:]) - np.median(counts[:few])))


def main() -> int:
    """Run, print, return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    happened = draw(args.minutes, args.seed)
    descriptors = Descriptors()
    with tempfile.TemporaryDirectory(prefix="ods-soak-") as name:
        descriptors.start()
        record = fly_mission(settings_of(Path(name), happened, args.minutes, args.seed))
        descriptors.end()
        log = (Path(name) / "out" / "run.log").read_text(errors="replace")
    lists = [message for _, message in record.lists]
    valid = sum(message.valid for message in lists)
    print(f"{args.minutes:g} minutes, seed {args.seed}: {len(happened)} faults, {len(record.truths)} pings, "
          f"{len(lists)} lists, {valid / max(len(lists), 1):.0%} valid")  # fmt: skip
    wrong = list(spells(record, happened))
    print(f"valid and wrong for over {TOLERATED_S:g} s: {len(wrong)}")
    for what, from_s, to_s in wrong:
        print(f"  {what:12} {from_s:7.1f} to {to_s:7.1f} s: {cause_of(from_s, happened)}")
    grown = list(growth(record, descriptors))
    for process, mb, more in grown:
        print(f"  {process:12} {mb:+6.2f} MB {more:+4d} descriptors")
    tracebacks = log.count("Traceback")
    print(f"tracebacks: {tracebacks}; counters: {json.dumps(_counters(record))}")
    return int(bool(wrong) or tracebacks > 0 or any(mb > GROWTH_MB or more > 0 for _, mb, more in grown))


def _counters(record: RunRecord) -> dict[str, int]:
    found: dict[str, int] = defaultdict(int)
    for reports in record.health.values():
        for name, count in (reports[-1].counters if reports else {}).items():
            if count and name in ("bad_ping", "failed_stage", "pose_jumps", "skipped_pings", "garbage_bytes"):
                found[name] += count
    return dict(found)


if __name__ == "__main__":
    sys.exit(main())
