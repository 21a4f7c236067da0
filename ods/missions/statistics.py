"""Rates with intervals, paired tests and other statistics of a campaign's arms."""

import math
from collections.abc import Sequence
from itertools import combinations

import msgspec
import numpy as np
from scipy.stats import binomtest

from ods.missions.outcome import Outcome

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


class Rate(msgspec.Struct, frozen=True):
    """A share of missions, with Wilson's interval."""

    count: int
    of: int
    share: float
    low: float
    """95 %"""
    high: float


class Summary(msgspec.Struct, frozen=True):
    """One arm."""

    arm: str
    success: Rate
    collision: Rate
    near_miss: Rate
    time_out: Rate
    clearance_m: list[float]
    """Least clearance of a mission: its QUANTILES over all missions with obstacles."""
    path_ratio: float | None
    """Mean length of the way over that of the straight one, of successful missions; none: there are none."""
    time_ratio: float | None
    """Mean time over that of the arm `none` in the same world, where both succeed; none: there are none."""
    path_over_best: float | None
    """Mean length of the way over that of the arm `all_knowing` in the same world, where both succeed; none: there are
    none; and so the time:"""
    time_over_best: float | None
    time_to_collision_s: list[float]
    """Time to collision at first confirmation, the least of a mission: its QUANTILES over missions that have one."""
    evasions: float
    """Mean a mission."""
    evasions_of_nothing: float
    not_valid_share: float
    """Of the time."""


class Paired(msgspec.Struct, frozen=True):
    """Two arms in the same worlds."""

    first: str
    second: str
    only_first_collides: int
    """Worlds in which the first arm collides and the second does not."""
    only_second_collides: int
    """Worlds in which the second arm collides and the first does not."""
    p: float
    """McNemar's exact test: how likely so much difference is by chance."""


def rate_of(count: int, of: int) -> Rate:
    """Return a share with its 95 % interval (Wilson 1927)."""
    interval = binomtest(count, of).proportion_ci(method="wilson")
    return Rate(count, of, count / of, float(interval.low), float(interval.high))


def summary_of(arm: str, outcomes: Sequence[Outcome], straight_m: float) -> Summary:
    """Return the statistics of an arm."""
    own = [each for each in outcomes if each.arm == arm]
    n = len(own)
    clearances = [each.clearance_m for each in own if each.clearance_m is not None]
    successes = [each for each in own if each.ending == "success"]
    alone, best = (_beside(successes, outcomes, other) for other in ("none", "all_knowing"))
    warnings = [each.time_to_collision_s for each in own if each.time_to_collision_s is not None]
    total_s = math.fsum(each.time_s for each in own)
    return Summary(
        arm=arm,
        success=rate_of(len(successes), n),
        collision=rate_of(sum(each.ending == "collision" for each in own), n),
        near_miss=rate_of(sum(each.near_miss for each in own), n),
        time_out=rate_of(sum(each.ending == "time-out" for each in own), n),
        clearance_m=_quantiles(clearances),
        path_ratio=_mean([each.path_m / straight_m for each in successes]),
        time_ratio=_mean([each.time_s / other.time_s for each, other in alone]),
        path_over_best=_mean([each.path_m / other.path_m for each, other in best]),
        time_over_best=_mean([each.time_s / other.time_s for each, other in best]),
        time_to_collision_s=_quantiles(warnings),
        evasions=sum(each.evasions for each in own) / n,
        evasions_of_nothing=sum(each.evasions_of_nothing for each in own) / n,
        not_valid_share=math.fsum(each.not_valid_s for each in own) / total_s,
    )


def paired(outcomes: Sequence[Outcome], arms: Sequence[str]) -> list[Paired]:
    """Compare the collisions of each two arms in the worlds that both went through (McNemar 1947, exact)."""
    own = {arm: [each for each in outcomes if each.arm == arm] for arm in arms}
    return [compared(first, own[first], second, own[second]) for first, second in combinations(arms, 2)]


def compared(first: str, its: Sequence[Outcome], second: str, others: Sequence[Outcome]) -> Paired:
    """Compare the collisions of two that are named, in the worlds that both went through (McNemar 1947, exact)."""
    collides = {each.mission: each.ending == "collision" for each in others}
    both = [(each.ending == "collision", collides[each.mission]) for each in its if each.mission in collides]
    only_first, only_second = both.count((True, False)), both.count((False, True))
    discordant = only_first + only_second
    p = float(binomtest(only_first, discordant).pvalue) if discordant else 1.0
    return Paired(first, second, only_first, only_second, p)


def _beside(own: Sequence[Outcome], outcomes: Sequence[Outcome], arm: str) -> list[tuple[Outcome, Outcome]]:
    """Return each with that of another arm in the same world, where that succeeds."""
    others = {each.mission: each for each in outcomes if each.arm == arm and each.ending == "success"}
    return [(each, others[each.mission]) for each in own if each.mission in others]


def _quantiles(values: Sequence[float]) -> list[float]:
    return [round(float(q), 3) for q in np.quantile(values, QUANTILES)] if values else []


def _mean(values: Sequence[float]) -> float | None:
    return math.fsum(values) / len(values) if values else None
