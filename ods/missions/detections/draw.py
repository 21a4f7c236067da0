"""Detections of a ping, drawn by laws: no image, no pipeline."""

import math
from collections.abc import Iterator
from itertools import starmap
from typing import Any, NamedTuple

import msgspec
import numpy as np
from scipy.special import expit

from ods.base.arrays import Floats, Indices, Mask
from ods.messages import Detection, Detections
from ods.missions.detections.laws import NODES, REACH, EchoLaw, Errors, Laws
from ods.missions.detections.sights import Fan, Sights, features_of

LARGEST_LOG = 12.0
"""Of logarithms before they are raised: beyond is no number of an echo."""
SMALLEST_M = 0.01
NOT_TOLD = 1e-6
"""A front so unlikely is one that is not reported."""


class Placed(NamedTuple):
    """Where the head is."""

    north_m: float
    east_m: float
    heading_rad: float


class _Law:
    """An `EchoLaw` as arrays."""

    def __init__(self, law: EchoLaw) -> None:
        self.mean, self.scale, self.quantiles, self.mixing, self.memory = (
            np.array(part, np.float64) for part in (law.mean, law.scale, law.quantiles, law.mixing, law.memory)
        )
        self.fresh = np.sqrt(1.0 - self.memory**2)

    def errors(self, features: Floats, scores: Floats) -> Floats:
        """Return the (m, Errors) of echoes with normal scores (m, Errors)."""
        place = np.clip((scores + REACH) * ((NODES - 1) / (2.0 * REACH)), 0.0, NODES - 1.001)
        below = place.astype(np.intp)
        column = np.arange(scores.shape[1])
        low, high = self.quantiles[column, below], self.quantiles[column, below + 1]
        spread = low + (place - below) * (high - low)
        return np.asarray(features @ self.mean + np.exp(np.minimum(features @ self.scale, LARGEST_LOG)) * spread)


class Drawing:
    """One mission's detections; the draws for each object and the received clutter are remembered."""

    def __init__(self, laws: Laws, bodies: int, fan: Fan, rng: np.random.Generator) -> None:
        """`bodies`: how many there are."""
        self._laws, self._fan, self._rng = laws, fan, rng
        self._ranges = [np.array(each, np.float64).reshape(-1, 2) for each in laws.processed_ranges_m]
        self._low, self._high = np.array(laws.lowest), np.array(laws.highest)
        self._logits = np.array([laws.seen, laws.faint, laws.cut], np.float64).T
        self._whole, self._cut = _Law(laws.whole), _Law(laws.cut_off)
        self._scores = np.full((bodies, len(Errors._fields)), math.nan)
        """Normal scores of each body's newest echo; not numbers: there was none."""
        self._before = np.ones(bodies, np.bool_)
        self._pool = laws.clutter.echoes
        self._received: list[tuple[int, float, float]] = []
        """Clutter of the ping before: which of the pool, and its place, north, east, m."""

    def detections(self, number: int, t_ns: int, utc_ns: int, sights: Sights, head: Placed) -> Detections:
        """Return the detections of a ping, sent at `t_ns`; `head`: at reception."""
        ranges = self._ranges[number % len(self._ranges)]
        found, faint = self._of_bodies(sights, _processed(sights.near_m, ranges))
        more, more_faint = self._of_clutter(head, ranges)
        return Detections(
            seq=number,
            ping_number=number,
            t_ns=t_ns,
            t_rx_ns=t_ns,
            utc_ns=utc_ns,
            sound_speed=self._fan.sound_speed,
            sector=self._laws.sector,
            detections=sorted(found + more, key=_bearing),
            processed_ranges_m=self._laws.processed_ranges_m[number % len(self._ranges)],
            faint=sorted(faint + more_faint, key=_bearing),
            heard_from_db=self._laws.heard_from_db,
        )

    def _of_bodies(self, sights: Sights, processed: Mask) -> tuple[list[Detection], list[Detection]]:
        features = np.clip(features_of(sights, self._before[sights.body], self._fan), self._low, self._high)
        dice = self._rng.random((len(features), 3))
        seen, faint, cut = (dice < expit(features @ self._logits)).T
        self._before[sights.body[processed]] = seen[processed]
        rows = np.flatnonzero(seen & processed)
        if not len(rows):
            return [], []
        scores = self._next_scores(sights.body[rows], cut[rows])
        errors = np.where(
            cut[rows, None], self._cut.errors(features[rows], scores), self._whole.errors(features[rows], scores)
        )
        echoes = echoes_of(Errors(*errors.T), sights.take(rows), cut[rows], self._fan)
        return _parted(echoes, faint[rows])

    def _next_scores(self, bodies: Indices, cut: Mask) -> Floats:
        """Return the (m, Errors) normal scores of their echoes, which remember those before."""
        fresh = self._rng.standard_normal((len(bodies), self._scores.shape[1]))
        mixed = np.where(cut[:, None], fresh @ self._cut.mixing.T, fresh @ self._whole.mixing.T)
        memory = np.where(cut[:, None], self._cut.memory, self._whole.memory)
        share = np.where(cut[:, None], self._cut.fresh, self._whole.fresh)
        before = self._scores[bodies]
        scores = np.where(np.isnan(before), mixed, memory * before + share * mixed)
        self._scores[bodies] = scores
        return np.asarray(scores)

    def _of_clutter(self, head: Placed, ranges: Floats) -> tuple[list[Detection], list[Detection]]:
        law, rng = self._laws.clutter, self._rng
        if not self._pool:
            return [], []
        kept = [each for each in self._received if rng.random() < law.stays]
        for which in rng.integers(len(self._pool), size=rng.poisson(law.per_scan * (1.0 - law.stays))).tolist():
            echo = self._pool[which]
            toward = head.heading_rad + echo.bearing_rad
            north = head.north_m + echo.range_m * math.cos(toward)
            kept.append((which, north, head.east_m + echo.range_m * math.sin(toward)))
        self._received, received, faint = [], [], []
        for which, north, east in kept:
            echo = _moved_to(self._pool[which], north, east, head)
            if abs(echo.bearing_rad) > self._fan.rays[-1] or echo.range_m > self._fan.range_max_m:
                continue
            self._received.append((which, north, east))
            if _processed(np.array([echo.near_m]), ranges)[0]:
                received.append(echo)
                faint.append(law.faint[which])
        return _parted(received, np.array(faint, np.bool_))


def echoes_of(errors: Errors, sights: Sights, cut: Mask, fan: Fan) -> list[Detection]:
    """Return the detections of bodies of which the errors are known; the other way round of `fitting.errors_of`.

    Not drawn, as no tracker looks at them: `cells` (1), `amplitude`, `elevation_rad`.
    """
    grown = {name: np.exp(np.clip(getattr(errors, name), -LARGEST_LOG, LARGEST_LOG)) for name in Errors._fields[3:11]}
    near = np.maximum(sights.near_m + errors.near, SMALLEST_M)
    middle = np.maximum(sights.near_m + sights.radius_m * (1.0 + errors.middle), near + SMALLEST_M)
    peak = 10.0 ** (np.clip(errors.snr, 0.0, 90.0) / 20.0)
    front = expit(errors.front)
    columns = (
        middle,
        sights.bearing + fan.beam_rad * errors.bearing,
        sights.radius_m * grown["radius"],
        peak,
        peak * grown["mean"],
        np.clip(errors.snr, 0.0, 90.0),
        np.ones(len(near), np.int64),
        grown["range_extent"],
        grown["bearing_extent"],
        grown["sigma_range"],
        grown["sigma_bearing"],
        grown["sigma_radius"],
        np.zeros(len(near)),
        np.zeros(len(near)),
        near,
        grown["sigma_near"],
        cut,
        np.where(cut, 0.0, np.exp(np.minimum(errors.onset, LARGEST_LOG))),
        np.where(front < NOT_TOLD, 0.0, front),
    )
    rows: Iterator[tuple[Any, ...]] = zip(*(column.tolist() for column in columns), strict=True)
    return list(starmap(Detection, rows))


def _moved_to(echo: Detection, north: float, east: float, head: Placed) -> Detection:
    """Return an echo as it is received from a place of that of another."""
    offset_n, offset_e = north - head.north_m, east - head.east_m
    range_m = math.hypot(offset_n, offset_e)
    bearing = math.remainder(math.atan2(offset_e, offset_n) - head.heading_rad, 2.0 * math.pi)
    near = max(SMALLEST_M, range_m - (echo.range_m - echo.near_m))
    return msgspec.structs.replace(echo, range_m=range_m, bearing_rad=bearing, near_m=near)


def _processed(range_m: Floats, ranges: Floats) -> Mask:
    """Return (m,) bool: ranges that were processed."""
    if not len(ranges):
        return np.ones(len(range_m), np.bool_)
    inside = (range_m[:, None] >= ranges[:, 0]) & (range_m[:, None] <= ranges[:, 1])
    return np.asarray(inside.any(axis=1))


def _parted(echoes: list[Detection], faint: Mask) -> tuple[list[Detection], list[Detection]]:
    weak = faint.tolist()
    return (
        [each for each, is_faint in zip(echoes, weak, strict=True) if not is_faint],
        [each for each, is_faint in zip(echoes, weak, strict=True) if is_faint],
    )


def _bearing(echo: Detection) -> float:
    return echo.bearing_rad
