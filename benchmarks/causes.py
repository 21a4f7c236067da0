"""`python -m benchmarks.causes`: physical causes that are no bodies, end to end: what a planner is told of each.

Three bodies over a flat bottom (config/scenes/figure11.toml, the vehicle under way at 1 m/s), 34 s of pings by the
simulator with one cause at a time, through the pipeline and the tracker as on board. False obstacles are active ones
that are farther than 3 m from every body, by their ids; `seen` is the share of the lists that have the bodies in view.
"""

import argparse
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np

from ods.assess.sea.bodies import SceneBodies
from ods.messages import ObstacleList, Ping
from ods.offline.mission import Mission, MissionSettings
from ods.offline.source import simulated
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.receiver.settings import Interference, LoudSpell, SecondWay
from ods.sim_sonar.scene.settings import Oscillation
from ods.sim_sonar.scene.timeline import Scene, load_scene

SCENE = Path("config/scenes/figure11.toml")
FULL_SCALE = 1e9
NEAR_M = 3.0
SETTLED_S = 3.0
Spoil = Callable[[Iterable[Ping]], Iterator[Ping]]


class Cause(NamedTuple):
    """One thing that goes wrong."""

    name: str
    image: dict[str, Any]
    """Keys of the scene's `image`."""
    vehicle: dict[str, Any] = {}
    spoil: Spoil = iter
    """What becomes of the pings on the way."""
    bed: bool = True
    seconds: float = 34.0


class Result(NamedTuple):
    """What a planner was told."""

    false: int
    seen: float
    """Share of the lists, after some seconds, that have a body, mean of the bodies."""
    valid: float
    invalid_until_s: float
    """Time of the last list that was not valid."""
    pings_dropped: int
    unseen: float
    """Mean share of the image."""
    first_s: float
    """When something was said first, s; NaN: nothing was."""
    said: str
    ms: float


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
    *[Cause(f"pulses each {p} s, {level} counts", pulses(level, p)) for p in (0.0371, 0.1, 0.149) for level in (1000, 3000)],
    Cause("pulses of two sonars", pulses(1000, 0.0371, 0.1)),
    Cause("pulses each 0.1 s, open water", pulses(1000, 0.1), bed=False),
    Cause("pulses each 0.149 s, open water", pulses(1000, 0.149), bed=False),
    *[Cause(f"continuous source, {level} counts, from {t} s", spoke(level, t)) for level in (1000, 3000) for t in (0.0, 12.0)],
    Cause("continuous source, open water", spoke(3000), bed=False),
    Cause("9 beams saturated", loud(FULL_SCALE, first_beam=40, beams=9)),
    Cause("9 beams saturated, 8 bits linear", LINEAR | loud(FULL_SCALE, first_beam=40, beams=9)),
    Cause("12 beams of noise at full scale", LINEAR | loud(6000.0, first_beam=40, beams=12)),
    Cause("60 % at full scale for 10 s", loud(FULL_SCALE, beams=36, from_s=5.0, to_s=15.0)),
    Cause("noise +30 dB for 10 s", loud(950.0, from_s=5.0, to_s=15.0), bed=False),
    Cause("noise +20 dB for 30 s", loud(300.0, from_s=5.0, to_s=35.0), bed=False, seconds=50.0),
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
    vehicle = msgspec.structs.replace(file.vehicle, **({"velocity_ned": (1.0, 0.0, 0.0)} | cause.vehicle))
    image = msgspec.structs.replace(file.image, **cause.image)
    bed = file.sea_bed if cause.bed else None
    return Scene(msgspec.structs.replace(file, vehicle=vehicle, image=image, sea_bed=bed, duration_s=cause.seconds))


def false_ids(told: ObstacleList, bodies: SceneBodies, t_s: float) -> tuple[set[int], list[bool]]:
    """Return the ids of active obstacles that are no body, and which bodies are in the list."""
    active = [o for o in told.obstacles if o.state == "active" and not suspect(o)]
    places = np.array([o.position_ned[:2] for o in active]).reshape(-1, 2)
    radii = np.array([o.radius_m for o in active])
    apart = bodies.distances(t_s, places)
    found = (apart <= NEAR_M + radii[:, None]).any(axis=0) if len(active) else np.zeros(apart.shape[1], np.bool_)
    return {o.id for o, row in zip(active, apart, strict=True) if row.min() > NEAR_M}, found.tolist()


def suspect(obstacle: Any) -> bool:
    """Tell whether the list itself says that it is likely none."""
    return getattr(obstacle, "multipath_probability", 0.0) > 0.5


def judged(cause: Cause) -> Result:
    """Return what is told of a cause."""
    scene = scene_of(cause)
    source = simulated(scene, find_sonar("seabat6012", SCENE))
    mission, bodies = Mission(MissionSettings()), SceneBodies(scene, 0.0)
    false: set[int] = set()
    seen, unseen, valid, spent = [], [], [], []
    invalid_until_s, said = 0.0, dict[str, float]()
    for step in mission.steps(cause.spoil(source.pings), source.poses):
        t_s = step.ping.t_ns / 1e9
        ids, found = false_ids(step.list, bodies, t_s)
        false |= ids
        for text in [step.list.unseen_why, *step.list.reasons, *getattr(step.detections, "warnings", [])]:
            if text and t_s > 1.5:
                said.setdefault(" ".join(word for word in text.split() if not word[0].isdigit()), t_s)
        spent.append(step.chain_ms)
        unseen.append(step.list.unseen_share)
        if t_s > SETTLED_S:
            seen.append(found)
            valid.append(step.list.valid)
            invalid_until_s = invalid_until_s if step.list.valid else t_s
    text = "; ".join(f"{text} ({t_s:.1f} s)" for text, t_s in list(said.items())[:3])
    return Result(len(false), float(np.mean(seen)), float(np.mean(valid)), invalid_until_s, mission.counters["bad_ping"],
                  float(np.mean(unseen)), min(said.values(), default=np.nan), text, float(np.median(spent)))  # fmt: skip


def main(args: Sequence[str] | None = None) -> None:
    """Print one line a cause."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="causes whose name has this")
    chosen = parser.parse_args(args).only
    print("| cause | false | bodies listed | valid | not valid until, s | pings dropped | unseen | first said, s | ms | said |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    began = time.monotonic()
    for cause in CAUSES:
        if chosen in cause.name:
            r = judged(cause)
            print(f"| {cause.name} | {r.false} | {r.seen:.2f} | {r.valid:.2f} | {r.invalid_until_s:.1f} | {r.pings_dropped} "
                  f"| {r.unseen:.2f} | {r.first_s:.1f} | {r.ms:.2f} | {r.said} |", flush=True)  # fmt: skip
    print(f"\n{time.monotonic() - began:.0f} s")


if __name__ == "__main__":
    main()
