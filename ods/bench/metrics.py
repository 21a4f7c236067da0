"""Judges a bench run: truth against obstacle lists. Pure."""

import math
from collections import defaultdict
from dataclasses import dataclass, field

import msgspec
import numpy as np
from scipy.optimize import linear_sum_assignment

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.bench.collector import RunRecord
from ods.bench.settings import BenchLimits
from ods.messages import Health, Obstacle, ObstacleList, Truth, TruthObject

STANDS_FOR_M = 5.0
"""An obstacle farther from an object than this does not stand for it."""
IN_PLAY = ("active", "stand_by", "hibernated")


class ObjectScore(msgspec.Struct, frozen=True):
    """How one object fared."""

    name: str
    tracked_share: float
    """Share of the lists, after `settle_s` in the sector, that have a track on it."""
    position_rms_m: float
    radius_error: float
    """Mean of estimated / true radius - 1."""
    ids: list[int]
    """Identities it had, in order."""


class ProcessScore(msgspec.Struct, frozen=True):
    """What one process cost."""

    name: str
    cpu_percent: float
    """Mean, of one core."""
    rss_mb: float
    """Largest."""
    starts: int


class Summary(msgspec.Struct, frozen=True):
    """The figures of a bench run; see `BenchLimits` for their meaning."""

    seconds: float
    pings: int
    pings_lost: int
    lists: int
    invalid_lists: int
    longest_gap_s: float
    latency_p50_ms: float
    latency_p99_ms: float
    latency_max_ms: float
    position_rms_m: float
    radius_error: float
    """Largest of the objects' absolute radius errors."""
    tracked_share: float
    """Smallest of the objects' shares."""
    false_tracks: int
    identity_switches: int
    objects: list[ObjectScore]
    processes: list[ProcessScore]
    back_s: dict[str, float]
    """Seconds from the kill of a process to its next sign of life."""
    counters: dict[str, dict[str, int]]
    """The processes' own counters, those that are not zero."""
    broken: list[str]
    """Limits that were broken, in plain words."""


def summarize(record: RunRecord, limits: BenchLimits, settle_s: float) -> Summary:
    """Return the figures of a run and the limits it broke."""
    arrivals = np.array([arrival for arrival, _ in record.lists], np.float64)
    answered = {item.ping_number: (arrival, item) for arrival, item in reversed(record.lists) if item.ping_number >= 0}
    latencies_ms = _latencies_ms(record, answered)
    objects, false_ids = _score_objects(record, settle_s)
    times = [truth.t_ns for truth in record.truths.values()]
    summary = Summary(
        seconds=(max(times) - min(times)) / NS if times else 0.0,
        pings=len(record.truths),
        pings_lost=sum(number not in answered for number in record.truths),
        lists=len(record.lists),
        invalid_lists=sum(not item.valid for _, item in record.lists),
        longest_gap_s=float(np.diff(arrivals).max() / NS) if len(arrivals) > 1 else math.inf,
        latency_p50_ms=_percentile(latencies_ms, 50),
        latency_p99_ms=_percentile(latencies_ms, 99),
        latency_max_ms=_percentile(latencies_ms, 100),
        position_rms_m=_position_rms_m(objects),
        radius_error=max((abs(o.radius_error) for o in objects), default=math.inf),
        tracked_share=min((o.tracked_share for o in objects), default=0.0),
        false_tracks=len(false_ids),
        identity_switches=sum(max(0, len(o.ids) - 1) for o in objects),
        objects=objects,
        processes=[_process_score(name, reports) for name, reports in record.health.items() if reports],
        back_s={name: _back_after(record, name, at_ns) for name, at_ns in record.kills},
        counters={name: _not_zero(reports[-1].counters) for name, reports in record.health.items() if reports},
        broken=[],
    )
    return msgspec.structs.replace(summary, broken=_broken(summary, limits))


def _latencies_ms(record: RunRecord, answered: dict[int, tuple[int, ObstacleList]]) -> Floats:
    """Return the time from each ping's last byte to its list.

    Writer and reader both stamp the last byte, each a little late when it has to wait for a core: the earlier counts.
    """
    found = []
    for number, truth in record.truths.items():
        if number in answered:
            arrival, item = answered[number]
            found.append((arrival - min(truth.t_sent_ns, item.t_rx_ns)) / 1e6)
    return np.array(found)


def _position_rms_m(objects: list[ObjectScore]) -> float:
    """Return the rms over all objects, each weighted by its share of the lists."""
    squares = [(o.position_rms_m**2, o.tracked_share) for o in objects if math.isfinite(o.position_rms_m)]
    return math.sqrt(sum(s * w for s, w in squares) / sum(w for _, w in squares)) if squares else math.inf


def _not_zero(counters: dict[str, int]) -> dict[str, int]:
    return {name: value for name, value in counters.items() if value}


def _percentile(values: Floats, percent: float) -> float:
    return float(np.percentile(values, percent)) if len(values) else math.inf


@dataclass
class _ObjectLog:
    """What the lists said about one object."""

    first_sight_ns: int | None = None
    expected: int = 0
    errors: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)
    ids: list[int] = field(default_factory=list)

    def note(self, target: TruthObject, found: Obstacle | None, t_ns: int, settle_s: float) -> None:
        if found is not None and self.ids[-1:] != [found.id]:
            self.ids.append(found.id)
        if not target.in_sector:
            return
        self.first_sight_ns = t_ns if self.first_sight_ns is None else self.first_sight_ns
        if t_ns - self.first_sight_ns < settle_s * NS:
            return
        self.expected += 1
        if found is not None:
            self.errors.append(_distance(found, target))
            self.ratios.append(found.radius_m / target.radius_m)

    def score(self, name: str) -> ObjectScore:
        return ObjectScore(
            name=name,
            tracked_share=len(self.errors) / self.expected,
            position_rms_m=float(np.sqrt(np.mean(np.square(self.errors)))) if self.errors else math.inf,
            radius_error=float(np.mean(self.ratios) - 1.0) if self.ratios else math.inf,
            ids=self.ids,
        )


def _score_objects(record: RunRecord, settle_s: float) -> tuple[list[ObjectScore], set[int]]:
    """Match obstacles with objects in every list; return a score an object and the ids that matched none, ever."""
    logs: dict[str, _ObjectLog] = defaultdict(_ObjectLog)
    all_ids: set[int] = set()
    for _, item in record.lists:
        truth = record.truths.get(item.ping_number)
        obstacles = [obstacle for obstacle in item.obstacles if obstacle.state in IN_PLAY]
        all_ids |= {obstacle.id for obstacle in obstacles}
        if truth is None:
            continue
        matched = match(truth, obstacles)
        for target in truth.objects:
            logs[target.name].note(target, matched.get(target.name), truth.t_ns, settle_s)
    true_ids = {number for log in logs.values() for number in log.ids}
    return [log.score(name) for name, log in sorted(logs.items()) if log.expected], all_ids - true_ids


def match(truth: Truth, obstacles: list[Obstacle]) -> dict[str, Obstacle]:
    """Return the obstacle that stands for each object, by name: least sum of horizontal distances in STANDS_FOR_M."""
    if not obstacles or not truth.objects:
        return {}
    far = 1e6
    cost = np.array([[_distance(obstacle, target) for obstacle in obstacles] for target in truth.objects])
    cost[cost > STANDS_FOR_M] = far
    rows, columns = linear_sum_assignment(cost)
    return {truth.objects[i].name: obstacles[j] for i, j in zip(rows, columns, strict=True) if cost[i, j] < far}


def _distance(obstacle: Obstacle, target: TruthObject) -> float:
    """Horizontal: one plane does not resolve depth."""
    return math.dist(obstacle.position_ned[:2], target.position_ned[:2])


def _process_score(name: str, reports: list[Health]) -> ProcessScore:
    return ProcessScore(
        name=name,
        cpu_percent=float(np.mean([report.cpu_percent for report in reports])),
        rss_mb=max(report.rss_mb for report in reports),
        starts=len({report.pid for report in reports}),
    )


def _back_after(record: RunRecord, name: str, at_ns: int) -> float:
    old = [report.pid for report in record.health[name] if report.t_ns <= at_ns]
    back = [report.t_ns for report in record.health[name] if report.t_ns > at_ns and report.pid not in old]
    return (min(back) - at_ns) / NS if back else math.inf


def _broken(summary: Summary, limits: BenchLimits) -> list[str]:
    most = {
        "position_rms_m": limits.position_rms_m,
        "radius_error": limits.radius_error,
        "false_tracks": limits.false_tracks,
        "pings_lost": limits.pings_lost,
        "latency_p50_ms": limits.latency_p50_ms,
        "latency_p99_ms": limits.latency_p99_ms,
        "longest_gap_s": limits.longest_gap_s,
    }
    found = [
        f"{name} is {getattr(summary, name):.3g}, the limit is {limit:g}"
        for name, limit in most.items()
        if not getattr(summary, name) <= limit
    ]
    if not summary.tracked_share >= limits.tracked_share:
        found.append(f"tracked_share is {summary.tracked_share:.3g}, the limit is {limits.tracked_share:g}")
    found += [
        f"{name} was back after {seconds:.1f} s, the limit is {limits.back_within_s:g}"
        for name, seconds in summary.back_s.items()
        if not seconds <= limits.back_within_s
    ]
    return found
