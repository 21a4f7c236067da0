"""Laws from what images led to: least squares, logits and ranks. Pure."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import expit, ndtr
from scipy.stats import norm, rankdata

from ods.base.arrays import Floats, Ints, Mask
from ods.messages import Detection, Detections
from ods.missions.detections.laws import NODES, REACH, ClutterLaw, EchoLaw, Errors
from ods.missions.detections.sights import WORDS, Fan, Sights, features_of

RIDGE = 1e-3
"""Against features that do not vary: in squares of what does."""
SMALL = 1e-4
"""Least scale: what does not vary has one, too."""
LOGIT = 15.0
FEWEST = 60
"""Echoes, for laws of their own."""
NEAR_M = 1.5
"""An echo of no body so near to one of the ping before is the same."""
KEPT = 300
"""Echoes of no body that are kept."""
STEPS = 30
SPLIT_M = 1.0
"""Distance beyond the object's radius at which an echo may begin, m."""


class Received(NamedTuple):
    """Bodies in view, over all pings: (m,) rows."""

    mission: Ints
    ping: Ints
    body: Ints
    features: Floats
    """(m, WORDS)"""
    seen: Mask
    faint: Mask
    cut: Mask
    errors: Floats
    """(m, Errors); of those that are not seen not numbers."""


class Alone(NamedTuple):
    """An echo of no body."""

    mission: int
    ping: int
    north_m: float
    east_m: float
    echo: Detection
    faint: bool


def matched(sights: Sights, echoes: Sequence[Detection], fan: Fan) -> list[int | None]:
    """Return which echo is that of each body: one a body at most, the nearest front first; None: it has none."""
    pairs = []
    for body, (near, radius, bearing, width) in enumerate(
        zip(sights.near_m, sights.radius_m, sights.bearing, sights.width, strict=True)
    ):
        for index, echo in enumerate(echoes):
            off = abs(echo.near_m - near)
            beside = abs(echo.bearing_rad - bearing) - 0.5 * (width + echo.bearing_extent_rad) - fan.beam_rad
            if beside < 0.0 and off < radius + SPLIT_M:
                pairs.append((off, body, index))
    found: list[int | None] = [None] * len(sights.body)
    taken = set()
    for _, body, index in sorted(pairs):
        if found[body] is None and index not in taken:
            found[body] = index
            taken.add(index)
    return found


class Gathering:
    """Takes looks in, ping by ping."""

    def __init__(self, fan: Fan) -> None:
        self._fan = fan
        self._rows: list[tuple[int, int, int, Floats, bool, bool, bool, Floats]] = []
        self.alone: list[Alone] = []
        self.pings = 0
        self._before: dict[int, bool] = {}

    def begin(self) -> None:
        """Start another mission."""
        self._before = {}

    def take(self, mission: int, sights: Sights, found: Detections, head: tuple[float, float, float]) -> None:
        """Take a ping; `head`: north, east, heading."""
        self.pings += 1
        sights = _processed(sights, found.processed_ranges_m)
        echoes = [*found.detections, *found.faint]
        which = matched(sights, echoes, self._fan)
        before = np.array([self._before.get(body, True) for body in sights.body.tolist()], np.bool_)
        features = features_of(sights, before, self._fan)
        for row, (body, index) in enumerate(zip(sights.body.tolist(), which, strict=True)):
            self._before[body] = index is not None
            errors, cut, faint = np.full(len(Errors._fields), math.nan), False, False
            if index is not None:
                echo = echoes[index]
                errors = errors_of(echo, float(sights.near_m[row]), float(sights.radius_m[row]),
                                   float(sights.bearing[row]), self._fan)  # fmt: skip
                cut, faint = echo.cut, index >= len(found.detections)
            self._rows.append((mission, found.ping_number, body, features[row], index is not None, faint, cut, errors))
        used = set(which)
        for index, echo in enumerate(echoes):
            if index not in used:
                toward = head[2] + echo.bearing_rad
                place = head[0] + echo.range_m * math.cos(toward), head[1] + echo.range_m * math.sin(toward)
                faint = index >= len(found.detections)
                self.alone.append(Alone(mission, found.ping_number, *place, echo, faint))

    def received(self) -> Received:
        """Return all that was taken in."""
        columns = zip(*self._rows, strict=True) if self._rows else [()] * 8
        mission, ping, body, features, seen, faint, cut, errors = columns
        return Received(
            np.array(mission, np.int64), np.array(ping, np.int64), np.array(body, np.int64),
            np.array(features, np.float64).reshape(-1, len(WORDS)),
            np.array(seen, np.bool_), np.array(faint, np.bool_), np.array(cut, np.bool_),
            np.array(errors, np.float64).reshape(-1, len(Errors._fields)),
        )  # fmt: skip


def errors_of(echo: Detection, near_m: float, radius_m: float, bearing: float, fan: Fan) -> Floats:
    """Return the (Errors,) of an echo of a body that is seen from `near_m` on, its middle at `bearing`."""
    sizes = (
        echo.radius_m / radius_m, echo.sigma_range_m, echo.sigma_bearing_rad, echo.sigma_radius_m, echo.sigma_near_m,
        echo.range_extent_m, echo.bearing_extent_rad, echo.mean / echo.peak,
    )  # fmt: skip
    front = min(max(echo.front, 1e-7), 1.0 - 1e-7)
    return np.array(
        [
            echo.near_m - near_m,
            (echo.range_m - near_m - radius_m) / radius_m,
            (echo.bearing_rad - bearing) / fan.beam_rad,
            *(math.log(max(size, SMALL)) for size in sizes),
            echo.snr_db,
            math.log(max(echo.onset, 0.05)),
            math.log(front / (1.0 - front)),
        ]
    )


def _processed(sights: Sights, ranges: Sequence[tuple[float, float]]) -> Sights:
    if not ranges:
        return sights
    looked = np.any([(sights.near_m >= near) & (sights.near_m <= far) for near, far in ranges], axis=0)
    return sights.take(looked)


def logit_of(features: Floats, happened: Mask) -> Floats:
    """Return (WORDS,) factors of the logit of a probability, by Newton's method with a ridge."""
    factors = np.zeros(features.shape[1])
    weight = RIDGE * len(features) * np.eye(features.shape[1])
    weight[0, 0] = 1e-6
    for _ in range(STEPS):
        expected = expit(np.clip(features @ factors, -LOGIT, LOGIT))
        slope = features.T @ (happened - expected) - weight @ factors
        curve = (features * np.maximum(expected * (1.0 - expected), 1e-9)[:, None]).T @ features + weight
        step = np.linalg.solve(curve, slope)
        factors = np.clip(factors + np.clip(step, -3.0, 3.0), -LOGIT, LOGIT)
    return factors


def echo_law(received: Received, rows: Mask) -> EchoLaw:
    """Return the law of those echoes."""
    features, errors = received.features[rows], received.errors[rows]
    mean = _least_squares(features, errors)
    left = errors - features @ mean
    size = np.log(np.abs(left) + SMALL)
    scale = _least_squares(features, size)
    standard = left / np.exp(features @ scale)
    nodes = ndtr(np.linspace(-REACH, REACH, NODES))
    quantiles = np.quantile(standard, nodes, axis=0).T
    scores = norm.ppf(rankdata(standard, axis=0) / (len(standard) + 1.0))
    correlation = np.nan_to_num(np.corrcoef(scores.T)) + 1e-6 * np.eye(scores.shape[1])
    np.fill_diagonal(correlation, 1.0 + 1e-6)
    mixing = np.asarray(np.linalg.cholesky(correlation), np.float64)
    return EchoLaw(
        _rows(mean),
        _rows(scale),
        _rows(quantiles),
        _rows(mixing),
        tuple(_memory(received, rows, scores).round(4).tolist()),
    )


def _least_squares(features: Floats, wanted: Floats) -> Floats:
    ridge = RIDGE * len(features) * np.eye(features.shape[1])
    ridge[0, 0] = 0.0
    return np.asarray(np.linalg.solve(features.T @ features + ridge, features.T @ wanted))


def _memory(received: Received, rows: Mask, scores: Floats) -> Floats:
    """Return the (Errors,) correlation of scores with those of the same body in the ping before."""
    keys = zip(received.mission[rows].tolist(), received.body[rows].tolist(), received.ping[rows].tolist(), strict=True)
    place = {key: index for index, key in enumerate(keys)}
    pairs = [(place[m, b, p - 1], index) for (m, b, p), index in place.items() if (m, b, p - 1) in place]
    if len(pairs) < FEWEST:
        return np.zeros(scores.shape[1])
    first, second = scores[np.array(pairs).T]
    norm_ = np.sqrt((first**2).sum(axis=0) * (second**2).sum(axis=0))
    return np.asarray(np.clip((first * second).sum(axis=0) / np.maximum(norm_, SMALL), 0.0, 0.99))


def clutter_law(alone: Sequence[Alone], pings: int) -> ClutterLaw:
    """Return the law of echoes of no body."""
    places: dict[tuple[int, int], list[tuple[float, float]]] = {}
    for each in alone:
        places.setdefault((each.mission, each.ping), []).append((each.north_m, each.east_m))
    again = sum(
        any(math.dist((each.north_m, each.east_m), other) < NEAR_M
            for other in places.get((each.mission, each.ping + 1), ()))
        for each in alone
    )  # fmt: skip
    some = alone[:: max(1, -(-len(alone) // KEPT))]
    echoes = [each.echo for each in some]
    stays = min(again / len(alone), 0.95) if alone else 0.0
    return ClutterLaw(round(len(alone) / pings, 5), round(stays, 4), echoes, [each.faint for each in some])


def _rows(table: Floats) -> list[tuple[float, ...]]:
    return [tuple(row) for row in table.round(5).tolist()]
