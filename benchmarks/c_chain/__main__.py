"""`python -m benchmarks.c_chain [rounds]`: ms from samples to detections, ours beside plain C for this processor.

Both get the same frames and take turns on one core. Plain C (sonar.c) equalizes by range, filters along the beams and
detects by two fixed levels, also where ours is the default chain, which does more: beams' gains, levels that follow the
background, how wide the filter is, circles with uncertainties, faint echoes. Plain C takes counts as they are: of
logarithmic ones, as the simulator's over a rocky bed are, only its time means anything.
"""

import argparse
import os
from functools import partial
from itertools import product
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.c_chain.frames import made_up_ping
from benchmarks.c_chain.plain_c import PlainC, built
from benchmarks.detection.speed import TIMED, Task, medians_ms
from ods.assess.sea.assessment import shipped_folder
from ods.assess.sea.run import images_of, scene_with_seed
from ods.base.arrays import Floats
from ods.messages import Ping
from ods.pipeline.chain import Chain
from ods.pipeline.fronts.judge import LeadingEdgeJudge
from ods.pipeline.prepared import prepared_chain
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.by_name import find_sonar

ROUNDS, FRAMES, SAMPLES = 20, 3, 2000
BEAMS, BITS = (60, 512), (8, 16)
MIDDLE: dict[str, dict[str, Any]] = {
    "FIR 9": {"use": "filter.fir"},
    "median 9": {"use": "filter.median"},
    "Wiener 9": {"use": "filter.wiener"},
}
DEFAULT, INSTEAD = "default", "FIR 9"
"""Of our chains, and which of theirs stands beside it."""
SEED, AFTER_S = 40, 3.0
"""Of the scene with a rocky bed, and the time from its beginning to the frames."""


class Unjudged(LeadingEdgeJudge):
    """Does not look at how echoes set in."""

    def of(self, bearing_rad: Floats, *_: Any) -> Floats:
        """Take all of them for bodies'."""
        return np.ones(len(bearing_rad))


def our_chain(name: str) -> Chain:
    """Return the default chain, or one with a filter and two levels."""
    if name == DEFAULT:
        return Chain(PipelineSettings())
    return Chain(PipelineSettings(stage=({"use": "equalize.mean_range"}, MIDDLE[name], {"use": "detect.two_level"})))


def mean_ms(contestants: dict[str, list[Task]], rounds: int) -> dict[str, float]:
    """Return the median times of each contestant's tasks, one a frame, averaged over the frames; they take turns."""
    tasks = {f"{name} {k}": tasks[k] for k in range(FRAMES) for name, tasks in contestants.items()}
    ms = medians_ms(tasks, rounds)
    return {name: float(np.mean([ms[f"{name} {k}"] for k in range(FRAMES)])) for name in contestants}


def print_row(text: str, plain: PlainC, name: str, pings: list[Ping], rounds: int) -> None:
    """Print times and detections of one of our chains, and of the one in plain C."""
    chain = our_chain(name)
    ours: list[Task] = [partial(chain.process, ping) for ping in pings]
    theirs: list[Task] = [plain.task(ping, INSTEAD if name == DEFAULT else name) for ping in pings]
    ms = mean_ms({"ours": ours, "theirs": theirs}, rounds)
    found = np.mean([len(task().detections) for task in ours]), np.mean([task() for task in theirs])
    times = f"{ms['ours']:8.3f}{ms['theirs']:9.3f}{ms['ours'] / ms['theirs']:7.2f}"
    print(f"{text:30}{times}{found[0]:9.1f}{found[1]:9.1f}", flush=True)


def judging_ms(pings: list[Ping], rounds: int) -> float:
    """Return how much longer the default chain takes as it judges how echoes set in."""
    judging, other = our_chain(DEFAULT), our_chain(DEFAULT)
    with patch.object(prepared_chain, "LeadingEdgeJudge", Unjudged):
        other.process(pings[0])  # prepares it
    both = {"with": judging, "without": other}
    ms = mean_ms({name: [partial(chain.process, ping) for ping in pings] for name, chain in both.items()}, rounds)
    return ms["with"] - ms["without"]


def rocky_pings() -> list[Ping]:
    """Return frames of spheres over a rocky sea-bed, by the simulator."""
    scene, sonar = scene_with_seed(shipped_folder() / "rocky.toml", SEED), find_sonar("seabat6012")
    return [shot.ping for shot in images_of(scene, sonar, AFTER_S)][-FRAMES:]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rounds", nargs="?", type=int, default=ROUNDS)
    rounds = parser.parse_args().rounds
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    rocky = rocky_pings()
    with built() as plain:
        print(f"ms, medians of {TIMED * rounds} interleaved runs on one core; detections a frame")
        print(f"{'':30}{'ODS':>8}{'plain C':>9}{'ratio':>7}{'ODS':>9}{'plain C':>9}")
        for beams, bits in product(BEAMS, BITS):
            pings = [made_up_ping(beams, SAMPLES, bits, seed) for seed in range(FRAMES)]
            for name in (*MIDDLE, DEFAULT):
                print_row(f"{beams} x {SAMPLES} uint{bits:<3} {name}", plain, name, pings, rounds)
        print_row(f"{rocky[0].beams} x {rocky[0].samples}, rocky bed, {DEFAULT}", plain, DEFAULT, rocky, rounds)
    print(f"of which judging how echoes set in: {judging_ms(rocky, rounds):.3f} ms")


if __name__ == "__main__":
    main()
