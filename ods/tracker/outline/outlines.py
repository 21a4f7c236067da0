"""Outlines and near edges of the confirmed objects, from the last images, beside the filters.

The extent is the mean matrix of second moments, as in tracking by random matrices (Koch, 2008, IEEE Transactions on
Aerospace and Electronic Systems 44(3)), without its weights: what limits it is which part of a body shines, not noise.
"""

import math
from dataclasses import replace
from typing import Generic, NamedTuple, TypeVar

import msgspec
import numpy as np

from ods.base.arrays import Floats, Ints
from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Obstacle, Outline
from ods.pose.buffer import PoseEstimate
from ods.tracker.outline.owners import Extents, owners_of
from ods.tracker.outline.seen import GlobalEchoes
from ods.tracker.output.snapshot import Snapshot

NEWEST_SHARE = 0.1
"""Least weight of the newest image in the means."""
COMMON_ERROR = 0.5
"""Part of the standard deviation claimed for a near edge, a radius or a place along the line of sight that images have
in common: they all show the same body from the same side."""
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
MIN_IMAGES = 3
"""Number of images that an outline needs."""
LENGTH_ERROR = 0.05
"""Standard deviation of a length that no number of images takes away, as a part of it: ends that do not shine."""

FloatsT = TypeVar("FloatsT", float, Floats)


class OutlineTable(NamedTuple, Generic[FloatsT]):
    """Outlines of objects: numbers, or (n,) arrays."""

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
    along_claim: FloatsT
    """The same of the place along the line of sight"""
    radius_claim: FloatsT
    """and of the radius."""
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


FIELDS = len(OutlineTable._fields)
FIRST_MEAN = OutlineTable._fields.index("north")


class Outlines:
    """Outlines of the confirmed objects, by their ids."""

    def __init__(self) -> None:
        self._ids: Ints = np.empty(0, np.int64)
        self._table, self._strips = np.zeros((FIELDS, 0)), np.zeros((0, len(_Strip._fields)))
        self._t_ns = 0
        self._head = np.zeros(3)

    @property
    def _known(self) -> OutlineTable[Floats]:
        """Views."""
        return OutlineTable(*self._table)

    def look(self, snapshot: Snapshot, seen: GlobalEchoes, head: PoseEstimate, utc_ns: int) -> None:
        """Take in the echoes of an image at `utc_ns`: those of the objects that were seen in it show their outlines."""
        self._follow(snapshot, head)
        known = self._known
        owner = owners_of(snapshot, seen, Extents(known.sights >= MIN_IMAGES, *known[FIRST_MEAN:-2]), utc_ns)
        position = np.ascontiguousarray(snapshot.position)
        native.take_outlines(known, position, seen, owner, NEWEST_SHARE, EDGE_KEPT_S)
        self._strips = np.empty((len(snapshot), len(_Strip._fields)))
        native.strips_of(known, MIN_IMAGES, ELONGATED_M, ELONGATED, LENGTH_ERROR, self._strips)

    def covering(self, snapshot: Snapshot) -> Snapshot:
        """Return the objects with circles that cover their outlines, where they have one, and with common errors.

        The circle of an echo of a wall seen aslant is as deep as it is wide, as that of a whole body is: too small.
        """
        rows = self._rows()
        of = np.array([rows.get(each, -1) for each in snapshot.id.tolist()], np.int64)
        radius, covariance = snapshot.radius.copy(), snapshot.covariance_ne.copy()
        sigma, sigma_radius = snapshot.sigma_position.copy("C"), snapshot.sigma_radius.copy()
        native.cover_outlines(
            self._known, self._strips, of, self._head, np.ascontiguousarray(snapshot.position),
            LIKELY, TOO_SMALL, COMMON_ERROR, radius, covariance, sigma, sigma_radius,
        )  # fmt: skip
        return replace(
            snapshot, radius=radius, covariance_ne=covariance, sigma_position=sigma, sigma_radius=sigma_radius
        )

    def _rows(self) -> dict[int, int]:
        return {each: k for k, each in enumerate(self._ids.tolist())}

    def outlined(self, obstacles: list[Obstacle], t_ns: int) -> list[Obstacle]:
        """Return obstacles with their outlines, and their edges if `t_ns` is the time of the newest image."""
        is_of_image = t_ns == self._t_ns
        rows, known, strips = self._rows(), self._table.T.tolist(), self._strips.tolist()
        return [
            obstacle
            if (row := rows.get(obstacle.id)) is None
            else _outlined(obstacle, OutlineTable(*known[row]), _Strip(*strips[row]), is_of_image)
            for obstacle in obstacles
        ]

    def _follow(self, snapshot: Snapshot, head: PoseEstimate) -> None:
        """Keep the objects of the snapshot, predicted to its time."""
        dt = max(0.0, (head.t_ns - self._t_ns) / NS) if len(self._ids) else 0.0
        old = self._rows()
        ids = snapshot.id.tolist()
        table = np.zeros((FIELDS, len(ids)))
        kept = [k for k, each in enumerate(ids) if each in old]
        table[:, kept] = self._table[:, [old[ids[k]] for k in kept]]
        known: OutlineTable[Floats] = OutlineTable(*table)
        away = snapshot.position - head.position_ned[:, None]
        sight = away / np.maximum(np.linalg.norm(away, axis=0), 1e-3)
        known.near[:] += dt * ((snapshot.velocity - head.velocity_ned[:, None]) * sight).sum(axis=0)
        moves = dt * snapshot.sigma_velocity[:2].max(axis=0, initial=0.0) ** 2
        known.near_variance[:] += dt * (moves + SIDE_CHANGES**2)
        known.unseen_s[:] += dt
        self._ids, self._table, self._t_ns, self._head = snapshot.id.copy(), table, head.t_ns, head.position_ned


def _outlined(obstacle: Obstacle, known: OutlineTable[float], strip: "_Strip", is_of_image: bool) -> Obstacle:
    near_m = sigma_near_m = outline = None
    if is_of_image and known.sights and known.unseen_s <= EDGE_KEPT_S:
        near_m, sigma_near_m = known.near, math.sqrt(known.near_variance + COMMON_ERROR**2 * known.near_claim)
    if strip.elongated > LIKELY:
        north, east, _ = obstacle.position_ned
        middle = north + known.north, east + known.east
        outline = Outline(middle, strip.half_length, strip.half_width, strip.azimuth, strip.sigma)
    return msgspec.structs.replace(
        obstacle, near_m=near_m, sigma_near_m=sigma_near_m, elongated=strip.elongated, outline=outline
    )


class _Strip(NamedTuple):
    """The strip with the same second moments; all 0 of what was seen too few times."""

    elongated: float
    """Probability."""
    half_length: float
    half_width: float
    azimuth: float
    sigma: float
    """Of the half length, m."""
