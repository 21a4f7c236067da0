"""Features of an echo's region, and a logistic regression on them: is it a body?"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from ods.assess.images.labelled import Target
from ods.base.arrays import Floats
from ods.messages import Detection, Ping, frame_of

BASE = 4.0
"""High level of the echoes that are looked at."""
_RIDGE = 1.0


class Weights(NamedTuple):
    """A fitted regression."""

    mean: Floats
    spread: Floats
    weight: Floats
    """The last one is the constant."""


def features_of(ping: Ping, found: Sequence[Detection]) -> Floats:
    """Return (detections, 7): peak, mean, extents in cells, elongation, contrast at the edge, shadow; dB or logs."""
    image, table = _decibels(ping), np.array(ping.bearing_rad)
    return np.array([_features(image, table, ping, one) for one in found]).reshape(-1, 7)


def _features(image: Floats, bearing: Floats, ping: Ping, one: Detection) -> list[float]:
    beams = max(one.bearing_extent_rad / (bearing[1] - bearing[0]), 1.0)
    samples = max(one.range_extent_m / ping.dr_m, 1.0)
    middle = int(np.searchsorted(bearing, one.bearing_rad)), int((one.range_m - ping.range0_m) / ping.dr_m)
    half = round(0.5 * beams), round(0.5 * samples)
    inside = _box(image, middle, half)
    around = _box(image, middle, (2 * half[0] + 1, 2 * half[1] + 2))
    ring = (around.sum() - inside.sum()) / max(around.size - inside.size, 1)
    far = middle[0], middle[1] + 3 * half[1] + 4
    behind, beside = _box(image, far, (half[0], half[1] + 2)), _box(image, far, (3 * half[0] + 2, half[1] + 2))
    across = one.bearing_extent_rad * one.range_m
    return [
        np.log(one.peak), np.log(one.mean), np.log(samples), np.log(beams),
        abs(float(np.log(max(across, ping.dr_m) / max(one.range_extent_m, ping.dr_m)))),
        float(inside.mean() - ring), float(beside.mean() - behind.mean()),
    ]  # fmt: skip


def _box(image: Floats, middle: tuple[int, int], half: tuple[int, int]) -> Floats:
    """Return the cells up to `half` away; the nearest cell where none is in the image."""
    first = [min(max(m - h, 0), n - 1) for m, h, n in zip(middle, half, image.shape, strict=True)]
    return image[first[0] : max(middle[0] + half[0], first[0]) + 1, first[1] : max(middle[1] + half[1], first[1]) + 1]


def _decibels(ping: Ping) -> Floats:
    counts = frame_of(ping).astype(np.float32)
    if ping.scale == "linear":
        return np.asarray(20.0 * np.log10(counts + 0.5))
    return np.asarray(20.0 / ping.scale_factor * counts)


def log_odds(weights: Weights, ping: Ping, found: Sequence[Detection]) -> Floats:
    """Return (detections,) the logarithm of the odds that each is a body."""
    if not found:
        return np.empty(0)
    scaled = (features_of(ping, found) - weights.mean) / weights.spread
    return np.asarray(scaled @ weights.weight[:-1] + weights.weight[-1])


def fitted(examples: Sequence[tuple[Ping, Sequence[Detection], Sequence[Target]]]) -> Weights:
    """Return the regression that fits detections of labelled images best; those in boxes that do not count are out."""
    table = np.vstack([features_of(ping, found) for ping, found, _ in examples])
    kinds = np.concatenate([[_kind(one, targets) for one in found] for _, found, targets in examples])
    table, is_body = table[kinds >= 0], kinds[kinds >= 0].astype(np.float64)
    mean, spread = table.mean(axis=0), table.std(axis=0) + 1e-9
    scaled = np.column_stack([(table - mean) / spread, np.ones(len(table))])

    def cost(weight: Floats) -> tuple[float, Floats]:
        value = scaled @ weight
        loss = float((np.logaddexp(0.0, value) - is_body * value).sum() + 0.5 * _RIDGE * (weight**2).sum())
        return loss, scaled.T @ (1.0 / (1.0 + np.exp(-value)) - is_body) + _RIDGE * weight

    return Weights(mean, spread, np.asarray(minimize(cost, np.zeros(scaled.shape[1]), jac=True).x))


def _kind(one: Detection, targets: Sequence[Target]) -> int:
    """Return 1 for a body, 0 for none, -1 for one that does not count."""
    inside = [
        target.counts
        for target in targets
        if target.range_m[0] <= one.range_m <= target.range_m[1]
        and target.bearing_rad[0] <= one.bearing_rad <= target.bearing_rad[1]
    ]
    return (1 if any(inside) else -1) if inside else 0
