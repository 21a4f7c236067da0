"""Draws what `benchmarks.detection.train_fronts` learns from: echoes found over rough beds, bodies or not.

`python -m benchmarks.detection.fronts_seen OUT.npz [--scenes 600] [--seed 0] [--sonar seabat6012]`: scenes with bodies
of many kinds over beds of many kinds; of each echo its window (`ods.pipeline.fronts.judge`) and whether it is a
body's: by the share of the echo's intensity that remains when the bed is taken away. The last lines are how well
today's network distinguishes them, so `--seed 7 --scenes 40 --sonar oculus_m750d` judges it before another sonar.
"""

import argparse
import math
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import msgspec
import numpy as np

from benchmarks.simulator.scene_text import Drawn, Surface, new_seed, object_text, scene_text as text_of
from ods.assess.sea.run import head_at
from ods.base.arrays import Floats, Floats32
from ods.messages import Detection, frame_of
from ods.pipeline.chain import Chain
from ods.pipeline.fronts.judge import LeadingEdgeJudge
from ods.pipeline.fronts.network import learnt
from ods.pipeline.prepared.plan import make_plan, sample_scale_of
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import Scene, load_scene
from ods.sim_sonar.shots import shot_at
from ods.sim_sonar.sonar.model import SonarModel

REACH_M = 100.0
"""Of the sonar for which these are; nearer, bodies lie as much nearer, and closer together."""
DOWN_M, PINGS, EVERY, BODIES = 20.0, 12, 5, 9
"""Depth of the sonar; pings of a scene that are looked at, every fifth; bodies in a scene."""
APART_M, NEAREST_M, FARTHEST_M = 9.0, 16.0, 92.0
LOOKED_AT_M = (-0.2, 0.6)
"""Of an echo, from where it sets in."""
MOSTLY, HARDLY = 0.6, 0.1
"""A body's is an echo of which at least this share remains without the bed, a bed's one of which at most this does."""
FALSE_SHARES = (0.003, 0.01, 0.03)
STAGES = [
    {"use": "equalize.beam_gain"},
    {"use": "equalize.mean_range"},
    {"use": "equalize.local"},
    {"use": "filter.fir", "round_beams": 1.0},
    {"use": "detect.two_level", "high": 5.5, "strongest": 0.12, "border": 1.4, "faint": 0.0, "fronts": False},
]
"""The default chain, but all that reaches the levels of speckle is an echo."""


class Seen(NamedTuple):
    """Echoes and what they are."""

    windows: Floats32
    """(echoes, BEAMS, CELLS) dB."""
    body: Floats
    """(echoes,) share of their intensity that is a body's."""


def scene_text(rng: np.random.Generator, nearer: float = 1.0) -> str:
    """Return a scene with bodies of many kinds over a bed of any kind; nearer: ranges are so many times those above."""
    depth, slope = DOWN_M + rng.uniform(2.0, 10.0), rng.choice([0.0, 0.0, rng.uniform(0.0, 4.0)])
    seed, speed, pitch, yaw = new_seed(rng), rng.uniform(0.0, 2.0), rng.uniform(0.0, 3.0), rng.uniform(0.0, 5.0)
    objects = _bodies(depth, slope, nearer, rng)
    drawn = Drawn(
        seed, speed, pitch, yaw, depth, slope,
        rms_height_m=math.exp(rng.uniform(math.log(0.03), math.log(0.4))),
        correlation_m=math.exp(rng.uniform(math.log(0.5), math.log(4.0))),
        cd=rng.uniform(0.2, 0.7), cs=rng.uniform(0.0, 0.3), range_correlation=rng.uniform(0.0, 0.3),
    )  # fmt: skip
    return text_of(drawn, objects, seconds=10.0, down_m=DOWN_M)


def _bodies(depth_m: float, slope_deg: float, nearer: float, rng: np.random.Generator) -> str:
    places: list[Floats] = []
    text = ""
    while len(places) < BODIES:
        at, turn = rng.uniform(NEAREST_M + 8.0, FARTHEST_M), math.radians(rng.uniform(-43.0, 43.0))
        place = at * nearer * np.array([math.cos(turn), math.sin(turn)])
        if all(np.hypot(*(place - other)) > nearer * APART_M for other in places):
            places.append(place)
            below = depth_m - place[0] * math.tan(math.radians(slope_deg))
            down = float(np.clip(below - rng.uniform(0.3, 7.0), DOWN_M - 4.0, DOWN_M + 6.0))
            text += _body(f"body {len(places)}", place, down, rng)
    return text


def _body(name: str, place: Floats, down: float, rng: np.random.Generator) -> str:
    shape = str(rng.choice(["sphere", "cylinder", "plane"], p=[0.5, 0.3, 0.2]))
    length, width = rng.uniform(0.5, 5.0), rng.uniform(0.5, 3.0)
    axis = ", ".join(f"{x:.2f}" for x in rng.normal(size=3) * (1.0, 1.0, 1.5) + (0.0, 0.0, 0.01))
    radius = math.exp(rng.uniform(math.log(0.25), math.log(2.5)))
    size = {
        "sphere": f"radius_m = {radius:.2f}",
        "cylinder": f"radius_m = {radius:.2f}\nlength_m = {length:.2f}\naxis_ned = [{axis}]",
        "plane": f"width_m = {width:.2f}\nheight_m = {length:.2f}\nnormal_ned = [{axis}]",
    }[shape]
    cd = math.exp(rng.uniform(math.log(0.02), math.log(0.3)))
    surface = Surface(cd, cd * rng.uniform(0.0, 1.0), rng.uniform(8.0, 30.0))
    return object_text(shape, name, place, down, size, surface)


def seen_in(scene: Scene, sonar: SonarModel) -> Iterator[Seen]:
    """Yield the echoes of some pings of a scene."""
    sim = ImageSimulator(sonar, scene)
    bare = sim.seeing(Scene(msgspec.structs.replace(scene.file, sea_bed=None)))
    settings = msgspec.convert({"stage": STAGES}, PipelineSettings)
    chain = Chain(settings)
    fronts: LeadingEdgeJudge | None = None
    for number in range(0, PINGS * EVERY, EVERY):
        ping = shot_at(sim, number).ping
        t_s = ping.t_ns / 1e9
        found = chain.process(ping, pose=head_at(scene, ping.t_ns))
        echoes = [*found.detections, *found.faint]
        if not echoes:
            continue
        fronts = fronts or LeadingEdgeJudge(make_plan(ping, settings).images[0])
        share = _shares(echoes, bare.mean_area(t_s), sim.mean_area(t_s), sonar)
        bearing_rad, near_m = np.array([(echo.bearing_rad, echo.near_m) for echo in echoes]).T
        yield Seen(fronts.windows(bearing_rad, near_m, frame_of(ping), sample_scale_of(ping)), share)


def _shares(echoes: list[Detection], bodies: Floats, all_of_it: Floats, sonar: SonarModel) -> Floats:
    shares = []
    for echo in echoes:
        beam = int(np.abs(sonar.plane_bearing_rad - echo.bearing_rad).argmin())
        beams = slice(max(beam - 1, 0), beam + 2)
        first, stop = (round((echo.near_m + m - sonar.range0_m) / sonar.dr_m) for m in LOOKED_AT_M)
        part = beams, slice(max(first, 0), max(stop, 1))
        shares.append(bodies[part].sum() / max(all_of_it[part].sum(), 1e-30))
    return np.array(shares)


def print_judged(windows: Floats32, share: Floats) -> None:
    """Print how well today's network distinguishes what is clearly a body's echo or the bed's."""
    scores = learnt().scores(windows)
    bodies, others = scores[share > MOSTLY], np.sort(scores[share < HARDLY])
    below = np.searchsorted(others, bodies) / len(others)
    print(f"bodies' echoes {len(bodies)}, the bed's {len(others)}; area under the curve {below.mean():.3f}")
    for part in FALSE_SHARES:
        print(f"{100 * part:.1f} % of the bed's taken for bodies': {100 * (below >= 1 - part).mean():.0f} % found")
    print(f"median log-odds: bodies {np.median(bodies):.1f}, bed {np.median(others):.1f}")


def main() -> None:
    """Write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--scenes", type=int, default=600)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sonar", default="seabat6012", metavar="NAME")
    args = parser.parse_args()
    sonar = find_sonar(args.sonar)
    nearer = min(sonar.samples * sonar.dr_m / REACH_M, 1.0)
    seen: list[Seen] = []
    scene_of: list[int] = []
    for number in range(args.scenes):
        rng = np.random.default_rng([args.seed, number])
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "scene.toml"
            file.write_text(scene_text(rng, nearer), encoding="utf-8")
            for each in seen_in(load_scene(file), sonar):
                seen.append(each)
                scene_of += [number] * len(each.body)
        if number % 20 == 19:
            print(number + 1, "scenes,", len(scene_of), "echoes", flush=True)
    windows, body = (np.concatenate(parts) for parts in zip(*seen, strict=True))
    np.savez_compressed(args.out, windows=windows.astype(np.float16), body=body, scene=np.array(scene_of))
    print_judged(windows, body)


if __name__ == "__main__":
    main()
