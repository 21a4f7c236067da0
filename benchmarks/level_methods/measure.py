"""What each method is worth: false echoes on clutter, bodies found at a rate of false echoes, time."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks.level_methods.cases import Case, Look
from benchmarks.level_methods.methods import Method
from ods.assess.detection.metrics import Score, at_false_alarms, interval_at_false_alarms

HALVINGS = 9
"""Of the interval between two levels, in search of one false echo an image of speckle."""
HALF = 0.5
"""Share of bodies found at which the loss is told."""


@dataclass
class Figures:
    """Of one method; `at_one` is its level for one false echo an image of speckle."""

    method: Method
    at_one: float
    ms: float = 0.0
    clutter: dict[str, float] = field(default_factory=dict)
    """False echoes an image at `at_one`, by kind."""
    half_db: float = float("nan")
    """Bodies of which HALF is found on speckle at `at_one`, dB over it."""
    found: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    """Share of bodies found at so many false echoes an image, and its interval, by kind of image."""


def score_at(method: Method, level: float, cases: Sequence[Case]) -> Score:
    """Return the score of the cases' last looks."""
    find, score = method.at(level), Score()
    for case in cases:
        found = [find(look) for look in case.looks[-method.pings :]][-1]
        score.count_image(found, case.targets)
    return score


def level_of_one(method: Method, cases: Sequence[Case]) -> float:
    """Return the level at which the cases, which show nothing, have one false echo each."""
    few, many = method.levels[0], method.levels[-1]
    for _ in range(HALVINGS):
        middle = 0.5 * (few + many)
        if score_at(method, middle, cases).false_per_image > 1.0:
            many = middle
        else:
            few = middle
    return 0.5 * (few + many)


def found_at(method: Method, cases: Sequence[Case], wanted: float) -> tuple[float, float, float]:
    """Return the share of bodies found at `wanted` false echoes an image, and its interval; nan: too few pings."""
    if any(len(case.looks) < method.pings for case in cases):
        return (float("nan"),) * 3
    scores = [score_at(method, level, cases) for level in method.levels]
    return at_false_alarms(scores, wanted), *interval_at_false_alarms(scores, wanted)


def half_found_db(method: Method, level: float, by_db: dict[float, list[Case]]) -> float:
    """Return at how many dB half of the bodies are found, interpolated; nan where that is beyond what was tried."""
    db = list(by_db)
    share = np.maximum.accumulate([score_at(method, level, cases).detection_probability for cases in by_db.values()])
    return float(np.interp(HALF, share, db, left=np.nan, right=np.nan))


def milliseconds(figures: Sequence[Figures], looks: Sequence[Look], rounds: int) -> list[float]:
    """Return the median processor time of each method for a ping, taken in turns."""
    finds = [one.method.at(one.at_one) for one in figures]
    spent = np.empty((rounds, len(finds)))
    for turn in range(-len(looks), rounds):  # the first looks prepare
        for index, find in enumerate(finds):
            find(looks[(turn - 1) % len(looks)])  # the first time finds the caches as the others left them
            began = time.thread_time_ns()
            find(looks[turn % len(looks)])
            spent[max(turn, 0), index] = time.thread_time_ns() - began
    return [float(value) for value in np.median(spent, axis=0) / 1e6]
