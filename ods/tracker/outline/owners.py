"""Which echoes of a ping are of which confirmed object: by its circle, or by its outline where that is known."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.tracker.outline.seen import Seen
from ods.tracker.output.snapshot import Snapshot

GATE = 1.5
"""An echo is of the object whose ellipse it fits best, if it is no farther from the object's place than so many times
the ellipse's axes, to which are added in squares"""
GATE_SIGMAS, GATE_M = 2.0, 0.5
"""so many standard deviations, and m."""


class Extents(NamedTuple):
    """Of n objects."""

    extended: Mask
    """(n,): those with an outline; the others are round, as far as is known yet."""
    middle_ne: Floats
    """(2, n) from the object's place to the outline's middle, m."""
    about: Floats
    """(3, n) second moments about it, m^2: north north, north east, east east."""


def owned(snapshot: Snapshot, seen: Seen, known: Extents, utc_ns: int) -> tuple[Indices, Indices]:
    """Return pairs of objects that were seen and their echoes, each echo once."""
    objects, echoes = _near_each_other(snapshot, seen, utc_ns)
    circle = snapshot.radius[objects] ** 2
    north, east = known.middle_ne[:, objects]
    round_ = np.stack([circle, 0.0 * circle, circle])
    seen_of = 3.0 * (known.about[:, objects] + np.stack([north * north, north * east, east * east]))
    nn, ne, ee = np.where(known.extended[objects], seen_of, round_)
    blur = _blur_m(snapshot, seen, objects, echoes) ** 2
    nn, ee = nn + blur, ee + blur
    area = nn * ee - ne * ne
    north, east = seen.place[echoes].T - snapshot.position[:2, objects]
    away = (ee * north**2 - 2.0 * ne * north * east + nn * east**2) / area
    best = np.lexsort((away + np.log(area), echoes))
    best = best[np.diff(echoes[best], prepend=-1) > 0]
    best = best[away[best] <= GATE**2]
    return objects[best], echoes[best]


def _near_each_other(snapshot: Snapshot, seen: Seen, utc_ns: int) -> tuple[Indices, Indices]:
    """Return the pairs of seen objects and echoes that their circles allow, whatever the last images showed."""
    live = np.flatnonzero(snapshot.last_seen_utc_ns == utc_ns)
    apart = np.hypot(*(seen.place.T[:, None, :] - snapshot.position[:2, live][:, :, None]))
    farthest = (snapshot.radius + GATE * GATE_SIGMAS * snapshot.sigma_position[:2].max(axis=0))[live]
    rows, echoes = np.nonzero(apart <= farthest[:, None] + (GATE * (GATE_SIGMAS * seen.sigma + GATE_M))[None, :])
    objects = live[rows]
    within = snapshot.radius[objects] + GATE * _blur_m(snapshot, seen, objects, echoes)
    largest = 2.0 * (snapshot.radius + GATE_SIGMAS * snapshot.sigma_radius)[objects] + GATE_M
    possible = (apart[rows, echoes] <= within) & (seen.radius[echoes] <= largest)
    return objects[possible], echoes[possible]


def _blur_m(snapshot: Snapshot, seen: Seen, objects: Indices, echoes: Indices) -> Floats:
    sigma = np.hypot(snapshot.sigma_position[:2, objects].max(axis=0, initial=0.0), seen.sigma[echoes])
    return np.asarray(np.hypot(GATE_SIGMAS * sigma, GATE_M))
