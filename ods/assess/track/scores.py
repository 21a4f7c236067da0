"""Scores of one run: GOSPA in view and of the memory, errors, identities, false tracks, latency, consistency."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ods.assess.track.case import Case, polar
from ods.assess.track.gospa import CUTOFF_M, gospa, pair
from ods.assess.track.identity import Frame, Hota, hota, idf1, similarity
from ods.assess.track.record import EAST_M, ID, NORTH_M, SCAN, STATUS, Record
from ods.base.arrays import Floats, Indices, Ints, Mask
from ods.tracker.existence import lifecycle

BAND_M, BAND_RAD = 2.0, np.deg2rad(1.5)
"""Objects and tracks so near to the sector's edge do not count in view."""
GATE_M = 3.0
"""A track farther from an object than this is not that object's."""
REMEMBERED_SCANS = 7
"""Scans that an object must have been in view to be remembered."""
REMEMBERED_S = 10.0
"""Time for which moving objects are remembered after they left the view, s."""
SETTLED_S = 1.0
"""Time after the first echo from which on consistency is judged, s."""


@dataclass(frozen=True)
class Scores:
    """One tracker on one scenario."""

    in_view: float
    """GOSPA, m, mean of all scans."""
    memory: float
    rmse_m: float
    """Root mean square distance of the tracks in view from their objects."""
    relative: float
    """The same over the range."""
    switches: int
    """How often an object's track changed its identity."""
    false_tracks: int
    """Identities that never were an object's."""
    latency_s: float
    """From an object's first echo to its first report, mean."""
    nees: Floats
    """(objects,) mean normalised squared error in north and east: 2 if errors are as large as reported."""
    ms: float
    """CPU time of a scan, median."""
    hota: Hota
    """Of what is in view now."""
    idf1: float


@dataclass
class _Tally:
    """Counts over the scans."""

    owner: dict[int, int] = field(default_factory=dict)
    """Object to the identity that it had last."""
    owned: set[int] = field(default_factory=set)
    switches: int = 0
    first: dict[int, float] = field(default_factory=dict)
    """Object to the time of its first report."""
    in_view: list[float] = field(default_factory=list)
    memory: list[float] = field(default_factory=list)
    errors: list[Floats] = field(default_factory=list)
    """(pairs, 2) squared error, squared error over range."""
    nees: list[Floats] = field(default_factory=list)
    """(pairs, 2) object, normalised squared error."""
    frames: list[Frame] = field(default_factory=list)


def score(case: Case, record: Record) -> Scores:
    """Return the scores of a run."""
    t, tally = case.scenario.t, _Tally()
    border = np.searchsorted(record.trk[:, SCAN], np.arange(len(t) + 1))
    views, remembered, seen = _views(case), _remembered(case), _seen_scans(case)
    first_echo = _first_echo(case)
    slant, _, _ = polar(case.truth, case.position, case.yaw)
    for k, now in enumerate(t.tolist()):
        rows = slice(border[k], border[k + 1])
        trk, spread = record.trk[rows], record.spread[rows]
        places = trk[:, (NORTH_M, EAST_M)]
        offset = places[None] - case.truth[k, :, None, :2]
        distance = np.hypot(offset[:, :, 0], offset[:, :, 1])
        objects, tracks = _identify(distance, trk[:, ID].astype(np.int64), tally, now)
        active = views[k][objects] & (trk[tracks, STATUS] == lifecycle.ACTIVE)
        objects, tracks = objects[active], tracks[active]
        _count_errors(tally, offset[objects, tracks], slant[k, objects])
        settled = now - first_echo[objects] >= SETTLED_S
        objects, tracks = objects[settled], tracks[settled]
        _count_nees(tally, objects, offset[objects, tracks], spread[tracks])
        judged = _judged(case, k, trk)
        tally.in_view.append(partial_gospa(distance[:, judged.counts], views[k], ~views[k], judged.edge))
        tally.frames.append(_frame(trk[judged.counts, ID], distance[:, judged.counts], views[k], judged.edge))
        optional = (seen[k] >= 1) & (seen[k] < REMEMBERED_SCANS)
        tally.memory.append(partial_gospa(distance, remembered[k], optional, np.zeros(len(trk), bool)))
    return _summary(record, tally, first_echo, seen[-1] >= REMEMBERED_SCANS)


def _views(case: Case) -> Mask:
    """Return (K, N): in view and not in the band at the sector's edge."""
    meta = case.scenario.meta
    slant, bearing, _ = polar(case.truth, case.position, case.yaw)
    clear = (slant < meta.range_max - BAND_M) & (np.abs(bearing) < meta.half_fov - BAND_RAD)
    return np.asarray(case.in_view & clear)


def _seen_scans(case: Case) -> Ints:
    return np.asarray(np.cumsum(case.in_view, axis=0))


def _remembered(case: Case) -> Mask:
    """Return (K, N): what the memory should hold."""
    t = case.scenario.t
    last = np.maximum.accumulate(np.where(case.in_view, t[:, None], -np.inf), axis=0)
    recent = t[:, None] - last <= REMEMBERED_S
    return np.asarray((_seen_scans(case) >= REMEMBERED_SCANS) & (recent | ~case.moving))


def _first_echo(case: Case) -> Floats:
    """Return (N,) time of each object's first echo; infinite without any."""
    first = np.full(case.truth.shape[1], np.inf)
    real = case.source >= 0
    np.minimum.at(first, case.source[real], case.scenario.t[case.scenario.det[real, 0].astype(int)])
    return first


def _identify(distance: Floats, ids: Ints, tally: _Tally, now: float) -> tuple[Indices, Indices]:
    """Return whose track each is: an object keeps the one that it had while that is near. Return objects and tracks."""
    row_of = {identity: row for row, identity in enumerate(ids.tolist())}
    pairs = {
        thing: row_of[identity]
        for thing, identity in tally.owner.items()
        if identity in row_of and distance[thing, row_of[identity]] < GATE_M
    }
    things = np.setdiff1d(np.arange(len(distance)), list(pairs))
    rest = np.setdiff1d(np.arange(len(ids)), list(pairs.values()))
    new = pair(distance[np.ix_(things, rest)], GATE_M)
    for thing, row in zip(things[new.objects].tolist(), rest[new.tracks].tolist(), strict=True):
        pairs[thing] = row
        identity = int(ids[row])
        tally.switches += tally.owner.get(thing, identity) != identity
        tally.owner[thing] = identity
        tally.owned.add(identity)
        tally.first.setdefault(thing, now)
    return np.array(list(pairs), np.intp), np.array(list(pairs.values()), np.intp)


def _count_errors(tally: _Tally, error: Floats, range_m: Floats) -> None:
    """Count (pairs, 2) errors at the (pairs,) objects' ranges."""
    square = (error**2).sum(axis=1)
    tally.errors.append(np.column_stack([square, square / range_m**2]))


def _count_nees(tally: _Tally, objects: Indices, error: Floats, spread: Floats) -> None:
    """Count (pairs, 2) errors against the (pairs, 3) reported covariances."""
    nn, ee, ne = spread.T
    north, east = error.T
    normalised = (ee * north**2 - 2.0 * ne * north * east + nn * east**2) / (nn * ee - ne**2)
    tally.nees.append(np.column_stack([objects, normalised]))


class _Judged(NamedTuple):
    """Which tracks of a scan count in view."""

    counts: Mask
    """(tracks,): active ones, and any other one inside the sector."""
    edge: Mask
    """(those that count,): in the band at the sector's edge."""


def _judged(case: Case, k: int, trk: Floats) -> _Judged:
    meta = case.scenario.meta
    places = np.zeros((len(trk), 7))
    places[:, :2] = trk[:, (NORTH_M, EAST_M)]
    places[:, 2] = case.position[k, 2]
    slant, bearing, _ = (a[0] for a in polar(places[None], case.position[k : k + 1], case.yaw[k : k + 1]))
    inside = (slant < meta.range_max) & (np.abs(bearing) < meta.half_fov)
    edge = np.abs(slant - meta.range_max) < BAND_M
    edge |= (np.abs(np.abs(bearing) - meta.half_fov) < BAND_RAD) & (slant < meta.range_max + BAND_M)
    counts = (trk[:, STATUS] == lifecycle.ACTIVE) | inside
    return _Judged(counts, edge[counts])


def _frame(ids: Floats, distance: Floats, view: Mask, edge: Mask) -> Frame:
    """Return a scan for identities: what GOSPA excuses is left out, unless it may be an object's in view."""
    excused = edge | (distance[~view] < GATE_M).any(axis=0)
    kept = ~excused | (distance[view] < GATE_M).any(axis=0)
    return Frame(np.flatnonzero(view), ids[kept].astype(np.int64), similarity(distance[np.ix_(view, kept)]))


def partial_gospa(distance: Floats, wanted: Mask, optional: Mask, excused: Mask) -> float:
    """Return GOSPA of the `wanted` objects for (objects, tracks) distances.

    A track without a partner does not count if it is `excused` or within the gate of an `optional` object.
    """
    pairing = pair(distance[wanted])
    alone = np.ones(distance.shape[1], bool)
    alone[pairing.tracks] = False
    alone &= ~excused
    if optional.any():
        alone &= ~(distance[optional] < GATE_M).any(axis=0)
    missed = int(wanted.sum()) - len(pairing.objects)
    return gospa(pairing.distance, missed, int(alone.sum()), CUTOFF_M)


def _summary(record: Record, tally: _Tally, first_echo: Floats, seen: Mask) -> Scores:
    errors, nees = np.concatenate(tally.errors), np.concatenate(tally.nees)
    delays = [when - first_echo[thing] for thing, when in tally.first.items() if seen[thing]]
    ids = set(record.trk[:, ID].astype(int).tolist())
    return Scores(
        in_view=float(np.mean(tally.in_view)),
        memory=float(np.mean(tally.memory)),
        rmse_m=_root_mean(errors[:, 0]),
        relative=_root_mean(errors[:, 1]),
        switches=tally.switches,
        false_tracks=len(ids - tally.owned),
        latency_s=float(np.mean(delays)) if delays else float("nan"),
        nees=np.array([nees[nees[:, 0] == thing, 1].mean() for thing in np.unique(nees[:, 0])]),
        ms=float(np.median(record.cpu_ms)),
        hota=hota(tally.frames),
        idf1=idf1(tally.frames),
    )


def _root_mean(squares: Floats) -> float:
    return float(np.sqrt(np.mean(squares))) if len(squares) else float("nan")
