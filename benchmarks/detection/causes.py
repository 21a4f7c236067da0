"""`benchmarks.detection.causes`: physical causes that are no bodies, end to end: what a planner is shown of each.

Three bodies over a flat bottom (config/scenes/figure11.toml, the vehicle under way at 1 m/s), 34 s of pings by the
simulator with one cause at a time, through the pipeline and the tracker as on board. False obstacles are active ones
in valid lists that are farther than 3 m from every body and not marked as multipath, by their ids.
"""

import argparse
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import msgspec
import numpy as np

from ods.assess.sea.scene_objects import SceneObjects
from ods.base.clock import NS
from ods.base.settings_file import load
from ods.messages import Obstacle, ObstacleList, Ping, Pose
from ods.offline.mission import Mission, MissionSettings
from ods.offline.source import simulated
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.echo.bodies.bodies import clearances
from ods.sim_sonar.receiver.settings import Interference, LoudSpell, SecondWay
from ods.sim_sonar.scene.motion import VehicleMotion
from ods.sim_sonar.scene.settings import Oscillation, SceneFile
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sonar_link.files.opening import open_pings

SCENE = Path("config/scenes/figure11.toml")
RECORDED = [Path("tests/data/aris/sample.aris"), Path("tests/data/oculus/three_pings_8bit.raw")]
FULL_SCALE = 1e9
NEAR_M = 3.0
CLEAR_M = 0.5
"""Nearer to a body, the sonar is taken to be inside."""
SETTLED_S = 3.0
PERIOD_S = 0.1493
Spoil = Callable[[Iterable[Ping]], Iterator[Ping]]


class Cause(NamedTuple):
    """One thing that goes wrong."""

    name: str
    image: dict[str, Any]
    """Keys of the scene's `image`."""
    vehicle: Mapping[str, Any] = MappingProxyType({})
    spoil: Spoil = iter
    """What becomes of the pings on the way."""
    bed: bool = True
    seconds: float = 34.0


class Result(NamedTuple):
    """What a planner was reported."""

    false: int
    false_s: float
    """Seconds that they were in lists, all together."""
    seen: float
    """Share of the lists, after some seconds, that have a body, mean of the bodies."""
    valid: float
    invalid_until_s: float
    """Time of the last list that was not valid."""
    dropped: int
    """Pings."""
    unseen: float
    """Mean share of the image."""
    ms: float
    """The chain's median."""
    said: dict[str, float]
    """And when first, s."""


def hanging(pings: Iterable[Ping], turn: int, change: bool, from_s: float = 10.0) -> Iterator[Ping]:
    """Yield pings whose images, from a time on, are `turn` former ones again and again, with one count changed."""
    kept: list[bytes] = []
    for number, ping in enumerate(pings):
        if ping.t_ns < from_s * 1e9:
            kept = [*kept[-turn + 1 :], ping.data] if turn > 1 else [ping.data]
            yield ping
            continue
        data = bytearray(kept[number % turn])
        if change:
            data[number % len(data)] ^= 1
        yield msgspec.structs.replace(ping, data=bytes(data))


def pulses(level: float, *periods: float) -> dict[str, Any]:
    """Return other sonars ahead that ping at these periods."""
    places = [(120.0, 25.0, 20.0), (110.0, -40.0, 20.0)]
    return {"interference": [Interference(position_ned=p, level_counts=level, period_s=s)
                             for p, s in zip(places, periods, strict=False)]}  # fmt: skip


def spoke(level: float, from_s: float = 0.0) -> dict[str, Any]:
    """Return a source without end."""
    return {"interference": [Interference(position_ned=(120.0, 25.0, 20.0), level_counts=level, from_s=from_s)]}


def loud(level: float, **keys: Any) -> dict[str, Any]:
    """Return noise in some beams for a time."""
    return {"loud_spells": [LoudSpell(level_counts=level, **keys)]}


LINEAR = {"samples": "linear8", "full_scale_counts": 6000.0}
STILL = {"velocity_ned": (0.0, 0.0, 0.0), "yaw": Oscillation(), "roll": Oscillation(), "pitch": Oscillation()}
CAUSES = [
    Cause("nothing", {}),
    *[Cause(f"pulses each {period} s, {level} counts", pulses(level, period))
      for period in (0.0371, 0.1, 0.149) for level in (1000, 3000)],
    Cause("pulses of two sonars", pulses(1000, 0.0371, 0.1)),
    Cause("pulses each 0.1 s, open water", pulses(1000, 0.1), bed=False),
    Cause("pulses each 0.149 s, open water", pulses(1000, 0.149), bed=False),
    *[Cause(f"continuous source, {level} counts, from {t} s", spoke(level, t))
      for level in (1000, 3000) for t in (0.0, 12.0)],
    Cause("continuous source, open water", spoke(3000), bed=False),
    Cause("9 beams saturated", loud(FULL_SCALE, first_beam=40, beams=9)),
    Cause("9 beams saturated, 8 bits linear", LINEAR | loud(FULL_SCALE, first_beam=40, beams=9)),
    Cause("12 beams of noise at full scale", LINEAR | loud(6000.0, first_beam=40, beams=12)),
    Cause("60 % at full scale for 10 s", loud(FULL_SCALE, beams=36, from_s=5.0, to_s=15.0)),
    Cause("noise +30 dB for 10 s", loud(950.0, from_s=5.0, to_s=15.0), bed=False),
    Cause("noise +20 dB for 30 s", loud(300.0, from_s=5.0, to_s=35.0), bed=False, seconds=60.0),
    Cause("the same image, one count changed", {}, spoil=lambda pings: hanging(pings, 1, True)),
    Cause("8 images in turn", {}, spoil=lambda pings: hanging(pings, 8, False)),
    Cause("the same image, one count changed, at rest", {}, STILL, lambda pings: hanging(pings, 1, True)),
    Cause("a second way, 6 m, -12 dB", {"second_ways": [SecondWay(longer_m=6.0, gain_db=-12.0)]}),
    Cause("a second way, 6 m, -20 dB", {"second_ways": [SecondWay(longer_m=6.0, gain_db=-20.0)]}),
    Cause("a second way, open water", {"second_ways": [SecondWay(longer_m=6.0, gain_db=-12.0)]}, bed=False),
]  # fmt: skip


def scene_of(cause: Cause) -> Scene:
    """Return the scene with the cause in it."""
    file = load_scene(SCENE).file
    vehicle = msgspec.structs.replace(file.vehicle, **{"velocity_ned": (1.0, 0.0, 0.0), **cause.vehicle})
    image = msgspec.structs.replace(file.image, **cause.image)
    bed = file.sea_bed if cause.bed else None
    return Scene(msgspec.structs.replace(file, vehicle=vehicle, image=image, sea_bed=bed, duration_s=cause.seconds))


def false_ids(reported: ObstacleList, bodies: SceneObjects, t_s: float) -> tuple[set[int], list[bool]]:
    """Return the ids of active obstacles that are no body, and which bodies are in the list."""
    active = [o for o in reported.obstacles if o.state == "active" and not suspect(o)]
    places = np.array([o.position_ned[:2] for o in active]).reshape(-1, 2)
    radii = np.array([o.radius_m for o in active])
    apart = bodies.distances(t_s, places)
    listed = [bool((row <= NEAR_M + radii).any()) for row in apart.T]
    return {o.id for o, row in zip(active, apart, strict=True) if row.min() > NEAR_M}, listed


def suspect(obstacle: Obstacle) -> bool:
    """Tell whether the list itself says that it is likely none."""
    return obstacle.multipath_of >= 0


def watched(pings: Iterable[Ping], mission: Mission, said: dict[str, float]) -> Iterator[Ping]:
    """Yield pings, and note when one of them was refused."""
    for ping in pings:
        yield ping
        if mission.counters["bad_ping"]:
            said.setdefault("pings refused", ping.t_ns / 1e9)


def judged(cause: Cause) -> Result:
    """Return what is reported of a cause."""
    scene = scene_of(cause)
    source = simulated(scene, find_sonar("seabat6012", SCENE))
    mission, bodies = Mission(MissionSettings()), SceneObjects(scene, 0.0)
    false: set[int] = set()
    seen, unseen, valid, spent = [], [], [], []
    invalid_until_s, false_s, said = 0.0, 0.0, dict[str, float]()
    for step in mission.steps(watched(cause.spoil(source.pings), mission, said), source.poses):
        t_s = step.ping.t_ns / 1e9
        ids, found = false_ids(step.list, bodies, t_s)
        if step.list.valid:
            false |= ids
            false_s += len(ids) * PERIOD_S
        for text in [step.list.unseen_why, *step.list.reasons, step.list.caution]:
            if text and t_s > 1.5:
                said.setdefault(" ".join(word for word in text.split() if not word[0].isdigit()), t_s)
        spent.append(step.chain_ms)
        unseen.append(step.list.unseen_share)
        if t_s > SETTLED_S:
            seen.append(found)
            valid.append(step.list.valid)
            invalid_until_s = invalid_until_s if step.list.valid else t_s
    return Result(
        len(false), false_s, float(np.mean(seen)), float(np.mean(valid)), invalid_until_s, mission.counters["bad_ping"],
        float(np.mean(unseen)), float(np.median(spent)), said,
    )  # fmt: skip


def called(pings: Iterable[Ping], poses: Sequence[Pose] = ()) -> tuple[int, Counter[str]]:
    """Return how many pings there are, and how many were called what."""
    mission, names, count = Mission(MissionSettings()), Counter[str](), 0
    for step in mission.steps(pings, poses):
        count += 1
        names.update({part.why for part in step.detections.unseen})
        names.update(["caution"] * bool(step.detections.caution))
        names.update(["multipath"] * any(suspect(o) for o in step.list.obstacles))
    names["dropped"] = mission.counters["bad_ping"]
    return count, +names


def until_a_body(scene: Scene, pings: Iterable[Ping]) -> Iterator[Ping]:
    """Yield pings until a body is around the sonar: the vehicles of some scenes are steered by a planner, not here."""

    def is_clear(ping: Ping) -> bool:
        t_s = ping.t_ns / NS
        return bool((clearances(scene.bodies_at(t_s), scene.head_at(t_s).position_ned) > CLEAR_M).all())

    return takewhile(is_clear, pings)


def print_false_alarms(recorded: Sequence[Path]) -> None:
    """Print what pings without such causes are called."""
    print("\n| pings | count | called |\n|---|---|---|")
    scenes = [*sorted(SCENE.parent.glob("sea/*.toml")), *sorted(SCENE.parent.glob("*.toml"))]
    for path in scenes:
        for sonar in ("oculus_m750d",) if path.stem == "oculus" else ("seabat6012",):
            file = load(path, SceneFile)
            scene = Scene(file, vehicle=VehicleMotion(file.vehicle))
            source = simulated(scene, find_sonar(sonar, path))
            count, names = called(until_a_body(scene, source.pings), source.poses)
            print(f"| {path.stem}, {sonar} | {count} | {dict(names)} |", flush=True)
    for path in [*RECORDED, *recorded]:
        count, names = called(open_pings(path).pings)
        print(f"| {path.name} | {count} | {dict(names)} |", flush=True)


def main(args: Sequence[str] | None = None) -> None:
    """Print one line a cause."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="causes whose name has this")
    parser.add_argument(
        "--false-alarms", action="store_true", help="what pings without such causes are called, instead"
    )
    parser.add_argument("--recorded", nargs="*", type=Path, default=[], help="more recordings for --false-alarms")
    chosen = parser.parse_args(args)
    if chosen.false_alarms:
        print_false_alarms(chosen.recorded)
        return
    print("| cause | false | for, s | bodies | valid | not until, s | dropped | unseen | said first, s | ms | said |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for cause in CAUSES:
        if chosen.only in cause.name:
            r = judged(cause)
            first_s = min(r.said.values(), default=np.nan)
            said = "; ".join(f"{text} ({t_s:.1f} s)" for text, t_s in list(r.said.items())[:3])
            numbers = (
                f"{r.false} | {r.false_s:.1f} | {r.seen:.2f} | {r.valid:.2f} | {r.invalid_until_s:.1f} | {r.dropped}"
            )
            more = f"{r.unseen:.2f} | {first_s:.1f} | {r.ms:.2f} | {said}"
            print(f"| {cause.name} | {numbers} | {more} |", flush=True)


if __name__ == "__main__":
    main()
