"""Judges a bench run: truth against obstacle lists. Pure."""

import math

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.bench.losses import PingLosses, explained_by_load, losses_of
from ods.bench.machine import MachineLoad
from ods.bench.settings import BenchLimits
from ods.bench.way.avoidance import Avoidance, missed as avoidance_missed
from ods.messages import Health
from ods.offline.run_record import Log, RunRecord
from ods.offline.score import ObjectScore, position_rms_m, score_objects


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
    losses: PingLosses
    """Where these were lost."""
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
    avoidance: Avoidance | None
    """Of a bench with a planner."""
    machine: MachineLoad
    """How busy the computer was."""
    broken: list[str]
    """Limits that were broken, in plain words."""
    not_judged: list[str]
    """Limits on times and losses that were not reached while the computer was busy."""


TIMES = frozenset({"latency_p50_ms", "latency_p99_ms", "longest_gap_s"})
"""Figures that say as much of a busy computer as of the program."""


def summarize(
    record: RunRecord,
    limits: BenchLimits,
    settle_s: float,
    machine: MachineLoad | None = None,
    avoidance: Avoidance | None = None,
) -> Summary:
    """Return the figures of a run and the limits it broke.

    machine: how busy the computer was; by default idle. avoidance: how a steered vehicle came through.
    """
    arrivals = np.array([arrival for arrival, _ in record.lists], np.float64)
    answered = {
        item.ping_number: (arrival, item.t_rx_ns) for arrival, item in reversed(record.lists) if item.ping_number >= 0
    }
    latencies_ms = _latencies_ms(record, answered)
    objects, false_ids = score_objects(record, settle_s)
    times = [truth.t_ns for truth in record.truths.values()]
    summary = Summary(
        seconds=(max(times) - min(times)) / NS if times else 0.0,
        pings=len(record.truths),
        pings_lost=sum(number not in answered for number in record.truths),
        losses=losses_of(record, set(answered)),
        lists=len(record.lists),
        invalid_lists=sum(not item.valid for _, item in record.lists),
        longest_gap_s=float(np.diff(arrivals).max() / NS) if len(arrivals) > 1 else math.inf,
        latency_p50_ms=_percentile(latencies_ms, 50),
        latency_p99_ms=_percentile(latencies_ms, 99),
        latency_max_ms=_percentile(latencies_ms, 100),
        position_rms_m=position_rms_m(objects),
        radius_error=max((abs(o.radius_error) for o in objects), default=math.inf),
        tracked_share=min((o.tracked_share for o in objects), default=0.0),
        false_tracks=len(false_ids),
        identity_switches=sum(max(0, len(o.ids) - 1) for o in objects),
        objects=objects,
        processes=[_process_score(name, reports) for name, reports in record.health.items() if reports],
        back_s={name: _back_after(record, name, at_ns) for name, at_ns in record.kills},
        counters={name: _not_zero(reports[-1].counters) for name, reports in record.health.items() if reports},
        avoidance=avoidance,
        machine=machine or MachineLoad(),
        broken=[],
        not_judged=[],
    )
    missed = _missed(summary, limits)
    if avoidance is not None and limits.avoid is not None:
        missed |= avoidance_missed(avoidance, limits.avoid)
    excused = {name for name in missed if _is_the_machines(name, summary, limits)}
    return msgspec.structs.replace(
        summary,
        broken=[text for name, text in missed.items() if name not in excused],
        not_judged=[text for name, text in missed.items() if name in excused],
    )


def _is_the_machines(name: str, summary: Summary, limits: BenchLimits) -> bool:
    """Return whether a busy computer explains a missed limit: one on times, or pings left out for lack of time."""
    if name == "pings_lost":
        return explained_by_load(summary.losses, limits.pings_lost, summary.machine)
    return summary.machine.busy and (name in TIMES or name in summary.back_s)


def _latencies_ms(record: RunRecord, answered: dict[int, tuple[int, int]]) -> Floats:
    """Return the time from each ping's last byte to its list.

    Writer and reader both stamp the last byte, each a little late when it has to wait for a core: the earlier counts.
    """
    found = []
    for number, truth in record.truths.items():
        if number in answered:
            arrival, read_ns = answered[number]
            found.append((arrival - min(truth.t_sent_ns, read_ns)) / 1e6)
    return np.array(found)


def _not_zero(counters: dict[str, int]) -> dict[str, int]:
    return {name: value for name, value in counters.items() if value}


def _percentile(values: Floats, percent: float) -> float:
    return float(np.percentile(values, percent)) if len(values) else math.inf


def _process_score(name: str, reports: Log[Health]) -> ProcessScore:
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


def _missed(summary: Summary, limits: BenchLimits) -> dict[str, str]:
    """Return the limits that were not reached, by name (a killed process: its name), in plain words."""
    most = {
        "position_rms_m": limits.position_rms_m,
        "radius_error": limits.radius_error,
        "false_tracks": limits.false_tracks,
        "pings_lost": limits.pings_lost,
        "latency_p50_ms": limits.latency_p50_ms,
        "latency_p99_ms": limits.latency_p99_ms,
        "longest_gap_s": limits.longest_gap_s,
    }
    found = {
        name: f"{name} is {getattr(summary, name):.3g}, the limit is {limit:g}"
        for name, limit in most.items()
        if limit is not None and not getattr(summary, name) <= limit
    }
    if "pings_lost" in found:
        found["pings_lost"] += f" ({summary.losses})"
    if limits.tracked_share is not None and not summary.tracked_share >= limits.tracked_share:
        found["tracked_share"] = f"tracked_share is {summary.tracked_share:.3g}, the limit is {limits.tracked_share:g}"
    return found | {
        name: f"{name} restarted after {seconds:.1f} s, the limit is {limits.back_within_s:g}"
        for name, seconds in summary.back_s.items()
        if not seconds <= limits.back_within_s
    }
