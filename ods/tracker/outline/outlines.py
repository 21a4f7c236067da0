"""The outlines and near edges of the confirmed objects: what the last images showed of each, beside the filters.

The extent is the mean matrix of second moments, as in tracking by random matrices (Koch, 2008, IEEE Transactions on
Aerospace and Electronic Systems 44(3)), without its weights: what limits it is which part of a body shines, not noise.
"""

import math
from dataclasses import replace
from typing import Generic, NamedTuple, TypeVar

import msgspec
import numpy as np

from ods.base.arrays import Floats, Indices, Ints
from ods.base.clock import NS
from ods.messages import Obstacle, Outline
from ods.pose.buffer import PoseEstimate
from ods.tracker.outline.seen import Seen
from ods.tracker.output.snapshot import Snapshot

NEWEST_SHARE = 0.1
"""Least weight of the newest image in the means."""
GATE = 1.5
"""An echo is of the object whose ellipse it fits best, if it is no farther from the object's place than so many times
the ellipse's axes, to which are added in squares"""
GATE_SIGMAS, GATE_M = 2.0, 0.5
"""so many standard deviations, and m."""
COMMON_ERROR = 0.5
"""Part of the standard deviation claimed for a near edge that images have in common."""
EDGE_KEPT_S = 2.0
"""What was not seen for longer has no near edge any more: another side of it may be the nearest."""
SIDE_CHANGES = 0.1
"""Standard deviation by which a near edge may change in a second as another side comes into view, m."""
ELONGATED_M, ELONGATED = 1.5, 4.0
"""An object is elongated from this half length on, and from so many times its half width: the front of a sphere, as far
as it shines, is 2.5 times as wide as deep."""
LIKELY = 0.9
"""From this probability on an object has an outline."""
TOO_SMALL = 2.0
"""A circle as deep as a wall that is seen aslant is too small by up to this factor: what is more is another echo."""
LEAST_SIGHTS = 3
"""Images that an outline takes."""
LENGTH_ERROR = 0.05
"""Standard deviation of a length that no number of images takes away, as a part of it: ends that do not shine."""

FloatsT = TypeVar("FloatsT", float, Floats)


class Known(NamedTuple, Generic[FloatsT]):
    """What is known of objects: numbers, or (n,) arrays."""

    sights: FloatsT
    """Images in which it was seen."""
    unseen_s: FloatsT
    """Time since the newest of these, s."""
    near: FloatsT
    """Slant range of the near edge from the head, m;"""
    near_variance: FloatsT
    """its variance by the images together, m^2, and"""
    near_claim: FloatsT
    """the mean of what the images claim, m^2: their errors are not independent."""
    north: FloatsT
    """From the object's place to the outline's middle, m,"""
    east: FloatsT
    north_north: FloatsT
    """Second moments, m^2:"""
    north_east: FloatsT
    east_east: FloatsT
    length: FloatsT
    """Mean of the half lengths in the images, m, and"""
    length_square: FloatsT
    """of their squares, m^2."""


FIELDS = len(Known._fields)
FIRST_MEAN = Known._fields.index("north")


class Outlines:
    """What is known of the confirmed objects, by their ids."""

    def __init__(self) -> None:
        self._ids: Ints = np.empty(0, np.int64)
        self._table = np.zeros((FIELDS, 0))
        self._t_ns = 0

    @property
    def _known(self) -> Known[Floats]:
        """Views."""
        return Known(*self._table)

    def look(self, snapshot: Snapshot, seen: Seen, head: PoseEstimate, utc_ns: int) -> None:
        """Take in the echoes of an image at `utc_ns`: those of the objects that were seen in it show their outlines."""
        self._follow(snapshot, head)
        objects, echoes = _owned(snapshot, seen, self._known, utc_ns)
        if not len(objects):
            return
        rows, parts = np.unique(objects, return_inverse=True)
        nearest = np.lexsort((seen.near[echoes], parts))[np.searchsorted(np.sort(parts), np.arange(len(rows)))]
        self._take_edges(rows, seen.near[echoes][nearest], seen.sigma_near[echoes][nearest] ** 2)
        middle, moments = _together(seen, echoes, parts, len(rows))
        nn, ne, ee = moments
        half = np.sqrt(1.5 * (nn + ee) + 3.0 * np.hypot(0.5 * (nn - ee), ne))
        self._take_extents(rows, (*(middle - snapshot.position[:2, rows]), *moments, half, half**2))

    def covering(self, snapshot: Snapshot) -> Snapshot:
        """Return the objects with circles that cover their outlines, where they have one.

        The circle of an echo of a wall seen aslant is as deep as it is wide, as that of a whole body is: too small.
        """
        place = {each: k for k, each in enumerate(self._ids.tolist())}
        radius, known = snapshot.radius.copy(), self._table.T.tolist()
        for k, each in enumerate(snapshot.id.tolist()):
            if each in place:
                reach = _reach(Known(*known[place[each]]))
                radius[k] = max(radius[k], min(reach, TOO_SMALL * radius[k]))
        return replace(snapshot, radius=radius)

    def outlined(self, obstacles: list[Obstacle], t_ns: int) -> list[Obstacle]:
        """Return obstacles with their outlines, and their edges if `t_ns` is the time of the newest image."""
        is_of_image = t_ns == self._t_ns
        place = {each: k for k, each in enumerate(self._ids.tolist())}
        known = self._table.T.tolist()
        return [
            _outlined(each, Known(*known[place[each.id]]), is_of_image) if each.id in place else each
            for each in obstacles
        ]

    def _follow(self, snapshot: Snapshot, head: PoseEstimate) -> None:
        """Keep the objects of the snapshot, carried on to its time."""
        dt = max(0.0, (head.t_ns - self._t_ns) / NS) if len(self._ids) else 0.0
        old = {each: k for k, each in enumerate(self._ids.tolist())}
        ids = snapshot.id.tolist()
        table = np.zeros((FIELDS, len(ids)))
        kept = [k for k, each in enumerate(ids) if each in old]
        table[:, kept] = self._table[:, [old[ids[k]] for k in kept]]
        known: Known[Floats] = Known(*table)
        away = snapshot.position - head.position_ned[:, None]
        sight = away / np.maximum(np.linalg.norm(away, axis=0), 1e-3)
        known.near[:] += dt * ((snapshot.velocity - head.velocity_ned[:, None]) * sight).sum(axis=0)
        moves = dt * snapshot.sigma_velocity[:2].max(axis=0, initial=0.0) ** 2
        known.near_variance[:] += dt * (moves + SIDE_CHANGES**2)
        known.unseen_s[:] += dt
        self._ids, self._table, self._t_ns = snapshot.id.copy(), table, head.t_ns

    def _take_edges(self, rows: Indices, near: Floats, variance: Floats) -> None:
        """Correct near edges, or begin with them."""
        known = self._known
        fresh = (known.sights[rows] == 0.0) | (known.unseen_s[rows] > EDGE_KEPT_S)
        before = known.near_variance[rows]
        gain = np.where(fresh, 1.0, before / (before + variance))
        known.near[rows] += gain * (near - known.near[rows])
        known.near_variance[rows] = gain * variance
        share = np.where(fresh, 1.0, _share_of(known.sights[rows]))
        known.near_claim[rows] += share * (variance - known.near_claim[rows])

    def _take_extents(self, rows: Indices, seen: tuple[Floats, ...]) -> None:
        """Take outlines in: place of the middle, second moments, half length and its square."""
        known = self._known
        known.sights[rows] += 1.0
        known.unseen_s[rows] = 0.0
        share = _share_of(known.sights[rows] - 1.0)
        for mean, new in zip(known[FIRST_MEAN:], seen, strict=True):
            mean[rows] += share * (new - mean[rows])


def _share_of(sights: Floats) -> Floats:
    """Return the weight of a new image after so many."""
    return np.maximum(NEWEST_SHARE, 1.0 / (sights + 1.0))


def _owned(snapshot: Snapshot, seen: Seen, known: Known[Floats], utc_ns: int) -> tuple[Indices, Indices]:
    """Return pairs of objects that were seen and their echoes, each echo once."""
    objects, echoes = _near_each_other(snapshot, seen, utc_ns)
    radius, north, east = snapshot.radius[objects], known.north[objects], known.east[objects]
    is_round = known.sights[objects] < LEAST_SIGHTS  # as far as is known yet
    nn, ne, ee = (
        np.where(is_round, circle, 3.0 * about)
        for circle, about in (
            (radius**2, known.north_north[objects] + north**2),
            (0.0 * radius, known.north_east[objects] + north * east),
            (radius**2, known.east_east[objects] + east**2),
        )
    )
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


def _together(seen: Seen, echoes: Indices, parts: Indices, count: int) -> tuple[Floats, tuple[Floats, Floats, Floats]]:
    """Return middle (2, count) and second moments of the objects that echoes are parts of, weighted by length."""
    weight = np.maximum(seen.length[echoes], 1e-3)

    def mean(values: Floats) -> Floats:
        return np.asarray(np.bincount(parts, weight * values, count) / np.bincount(parts, weight, count))

    middle = np.stack([mean(axis) for axis in seen.place[echoes].T])
    apart = seen.place[echoes] - middle.T[parts]
    moments = seen.extent[echoes] + apart[:, :, None] * apart[:, None, :]
    return middle, (mean(moments[:, 0, 0]), mean(moments[:, 0, 1]), mean(moments[:, 1, 1]))


def _principal(nn: float, ne: float, ee: float) -> tuple[float, float]:
    """Return the standard deviations along the principal axes, the larger first."""
    mean, gap = 0.5 * (nn + ee), math.hypot(0.5 * (nn - ee), ne)
    return math.sqrt(mean + gap), math.sqrt(max(0.0, mean - gap))


def _reach(known: Known[float]) -> float:
    """Return the radius of the circle about the object's place that covers its outline, m; 0: it has none."""
    strip = _strip(known)
    if strip is None or strip.elongated <= LIKELY:
        return 0.0
    return math.hypot(known.north, known.east) + strip.half_length


def _outlined(obstacle: Obstacle, known: Known[float], is_of_image: bool) -> Obstacle:
    near_m = sigma_near_m = outline = None
    if is_of_image and known.sights and known.unseen_s <= EDGE_KEPT_S:
        near_m, sigma_near_m = known.near, math.sqrt(known.near_variance + COMMON_ERROR**2 * known.near_claim)
    strip = _strip(known)
    elongated = 0.0 if strip is None else strip.elongated
    if strip is not None and elongated > LIKELY:
        north, east, _ = obstacle.position_ned
        middle = north + known.north, east + known.east
        outline = Outline(middle, strip.half_length, strip.half_width, strip.azimuth, strip.sigma)
    return msgspec.structs.replace(
        obstacle, near_m=near_m, sigma_near_m=sigma_near_m, elongated=elongated, outline=outline
    )


class _Strip(NamedTuple):
    """The strip with the same second moments."""

    elongated: float
    """Probability."""
    half_length: float
    half_width: float
    azimuth: float
    sigma: float
    """Of the half length, m."""


def _strip(known: Known[float]) -> _Strip | None:
    """Return the strip of an object; None: it was seen too few times."""
    if known.sights < LEAST_SIGHTS:
        return None
    along, across = _principal(known.north_north, known.north_east, known.east_east)
    half_length, half_width = math.sqrt(3.0) * along, math.sqrt(3.0) * across
    spread = math.sqrt(max(0.0, known.length_square - known.length**2))
    sigma = math.hypot(spread, LENGTH_ERROR * half_length) + 1e-3
    excess = half_length - max(ELONGATED_M, ELONGATED * half_width)
    azimuth = 0.5 * math.atan2(2.0 * known.north_east, known.north_north - known.east_east)
    elongated = 0.5 * math.erfc(-excess / sigma * math.sqrt(0.5))
    return _Strip(elongated, half_length, half_width, azimuth % math.pi, sigma)
