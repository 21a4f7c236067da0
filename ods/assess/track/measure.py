"""Runs every observer with every association, the reference and the library's trackers over the scenarios, in turns."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import bootstrap, chi2

from ods.assess.track import peers, record, reference
from ods.assess.track.scenarios import Kind, Limits, make
from ods.assess.track.scores import Scores, score
from ods.base.arrays import Floats
from ods.base.choices import none_of
from ods.base.errors import OdsError
from ods.tracker.association.registry import ASSOCIATIONS
from ods.tracker.observer.registry import OBSERVERS
from ods.tracker.settings import TrackerSettings

CONFIGURED = "configured"
"""Name of the tracker of `--config`."""
RELATIVE_LIMIT = 0.01
"""Of the range, for position errors."""
LATENCY_LIMIT_S = 0.35
"""Or that of the reference, which waits for the third echo, however many scans that takes."""


@dataclass(frozen=True)
class Row:
    """One tracker on one scenario: figures over all seeds."""

    scenario: str
    tracker: str
    ours: bool
    gospa: float
    reference: float
    """GOSPA of the reference."""
    ratio_interval: tuple[float, float]
    """Of `ratio`, 95 %, by bootstrap over the seeds; nan for a single one."""
    memory: float
    """Memory score over the reference's."""
    rmse_m: float
    rmse_reference_m: float
    relative: float
    switches: int
    """Of all seeds together."""
    false_tracks: int
    latency_s: float
    latency_reference_s: float
    nees: float
    nees_reference: float
    nees_band: tuple[float, float]
    """Where 95 % of the means of a number of consistent, independent objects lie."""
    ms: float
    hota: float
    hota_reference: float
    association: float
    """AssA: HOTA's share of identities."""
    idf1: float
    limits: Limits

    @property
    def ratio(self) -> float:
        """GOSPA over the reference's."""
        return self.gospa / self.reference

    def missed(self) -> list[str]:
        """Return the names of the targets that were not reached."""
        limits, (_, high) = self.limits, self.nees_band
        broken = {
            "GOSPA": limits.gospa is not None and not self.ratio <= limits.gospa,
            "memory": limits.memory is not None and not self.memory <= limits.memory,
            "error": not self.relative <= RELATIVE_LIMIT,
            "switches": limits.switches is not None and self.switches > limits.switches,
            "false": self.false_tracks > 0,
            "latency": not self.latency_s <= max(LATENCY_LIMIT_S, self.latency_reference_s),
            "NEES": limits.consistent and not self.nees <= high,
        }
        return [name for name, is_broken in broken.items() if is_broken]


def rows(
    kinds: Mapping[str, Kind], seeds: Sequence[int], trackers: Mapping[str, TrackerSettings], with_peers: bool
) -> Iterator[Row]:
    """Yield the rows scenario by scenario; the library runs with the first seed only."""
    for name, kind in kinds.items():
        cases = [make(name, seed, kinds) for seed in seeds]
        truth = [score(case, reference.run_reference(case)) for case in cases]
        found: dict[str, list[Scores]] = {tracker: [] for tracker in trackers}
        for case in cases:
            for tracker, settings in trackers.items():
                found[tracker].append(score(case, record.run_tracker(case.scenario, settings)))
        for tracker, scores in found.items():
            yield replace(_row_of(tracker, scores, truth), scenario=name, limits=kind.limits)
        for peer in kind.peers if with_peers else ():
            scores = [score(cases[0], peers.PEERS[peer](cases[0]))]
            yield replace(_row_of(peer, scores, truth[:1]), scenario=name, limits=kind.limits, ours=False)


def contenders(names: Sequence[str], configured: TrackerSettings | None) -> dict[str, TrackerSettings]:
    """Return every observer with every association, or those of `names`, and the user's own. Raises OdsError."""
    found = {
        f"{observer}, {way}": TrackerSettings(observer=observer, association=way)
        for observer in OBSERVERS
        for way in ASSOCIATIONS
    }
    unknown = [name for name in names if name not in found]
    if unknown:
        raise OdsError(f"--trackers: {none_of(unknown[0], found)}")
    found = {name: found[name] for name in names or found}
    return found if configured is None else {**found, CONFIGURED: configured}


def _row_of(tracker: str, scores: Sequence[Scores], truth: Sequence[Scores]) -> Row:
    """Return the figures of some seeds, and of the reference with the same seeds, of a scenario without limits."""
    nees = np.concatenate([one.nees for one in scores])
    return Row(
        scenario="",
        tracker=tracker,
        ours=True,
        gospa=_mean([one.in_view for one in scores]),
        reference=_mean([one.in_view for one in truth]),
        ratio_interval=ratio_interval([one.in_view for one in scores], [one.in_view for one in truth]),
        memory=_mean([one.memory for one in scores]) / _mean([one.memory for one in truth]),
        rmse_m=_mean([one.rmse_m for one in scores]),
        rmse_reference_m=_mean([one.rmse_m for one in truth]),
        relative=_mean([one.relative for one in scores]),
        switches=sum(one.switches for one in scores),
        false_tracks=sum(one.false_tracks for one in scores),
        latency_s=_mean([one.latency_s for one in scores]),
        latency_reference_s=_mean([one.latency_s for one in truth]),
        nees=_mean(nees),
        nees_reference=_mean(np.concatenate([one.nees for one in truth])),
        nees_band=nees_band(len(nees)),
        ms=float(np.median([one.ms for one in scores])),
        hota=_mean([one.hota.hota for one in scores]),
        hota_reference=_mean([one.hota.hota for one in truth]),
        association=_mean([one.hota.association for one in scores]),
        idf1=_mean([one.idf1 for one in scores]),
        limits=Limits(),
    )


def _mean(values: Sequence[float] | Floats) -> float:
    return float(np.mean(values)) if len(values) else float("nan")


def ratio_interval(values: Sequence[float], references: Sequence[float]) -> tuple[float, float]:
    """Return the 95 % interval of the ratio of two means of the same seeds, by bootstrap; nan for less than two."""
    if len(values) < 2:
        return float("nan"), float("nan")
    found = bootstrap(
        (values, references), lambda a, b: np.mean(a) / np.mean(b), paired=True, vectorized=False,
        method="percentile", n_resamples=500, rng=np.random.default_rng(0),
    ).confidence_interval  # fmt: skip
    return float(found.low), float(found.high)


def nees_band(objects: int) -> tuple[float, float]:
    """Return the 95 % band of the mean of `objects` independent squared errors of two coordinates.

    An object's errors of one run hang together, so each object counts once.
    """
    if objects == 0:
        return float("nan"), float("nan")
    low, high = chi2.ppf(np.array([0.025, 0.975]), 2 * objects) / objects
    return float(low), float(high)
