"""The difference of detections: what two chains find in the same ping, and what only one of them finds."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.messages import Detection


class Difference(NamedTuple):
    """Places in the lists of A and of B."""

    both: list[tuple[int, int]]
    """Of A and of B."""
    only_a: list[int]
    only_b: list[int]


def difference(a: Sequence[Detection], b: Sequence[Detection]) -> Difference:
    """Match the detections whose circles overlap, one to one, those that overlap most first."""
    radii_a, radii_b = (np.array([one.radius_m for one in found], np.float64) for found in (a, b))
    return matched(_places(a), radii_a, _places(b), radii_b)


def matched(places_a: Floats, radii_a: Floats, places_b: Floats, radii_b: Floats) -> Difference:
    """Match circles that overlap, one to one, those that overlap most first; places: (n, d) of the centres, m.

    How much: the distance of the centres in units of the sum of the radii; touching ones have 1.
    """
    apart = np.linalg.norm(places_a[:, None, :] - places_b[None, :, :], axis=-1)
    reach = radii_a[:, None] + radii_b[None, :]
    overlapping = apart <= reach
    order = np.argsort(np.where(overlapping, apart / np.maximum(reach, 1e-9), math.inf), axis=None, kind="stable")
    both: list[tuple[int, int]] = []
    free_a, free_b = set(range(len(radii_a))), set(range(len(radii_b)))
    for flat in order[: int(overlapping.sum())].tolist():
        one, other = divmod(flat, len(radii_b))
        if one in free_a and other in free_b:
            both.append((one, other))
            free_a.remove(one)
            free_b.remove(other)
    return Difference(sorted(both), sorted(free_a), sorted(free_b))


def _places(found: Sequence[Detection]) -> Floats:
    """Return (n, 3) the centres in the sonar's frame, m."""
    rows = [
        (
            one.range_m * math.cos(one.elevation_rad) * math.cos(one.bearing_rad),
            one.range_m * math.cos(one.elevation_rad) * math.sin(one.bearing_rad),
            one.range_m * math.sin(one.elevation_rad),
        )
        for one in found
    ]
    return np.array(rows).reshape(-1, 3)
