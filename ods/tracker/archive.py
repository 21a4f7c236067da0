"""Hibernated objects that are out of sight: they cost nothing a ping until the sonar looks at their place again.

Only the objects within reach of the vehicle are looked at, and that neighbourhood is found anew only when the vehicle
has moved on by `SKIN_M` (the neighbour list of molecular dynamics, after Verlet).
"""

import msgspec
import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.messages import Vector3
from ods.tracker.columns import Columns

SKIN_M = 20.0
"""The vehicle may move so far before the neighbourhood is found anew."""


class MapObject(msgspec.Struct, frozen=True):
    """A hibernated object, with what was known when it was last seen."""

    id: int
    position: Vector3
    """NED, m."""
    sigma: Vector3
    """Standard deviations of the position, m."""
    radius: float
    sigma_radius: float
    existence: float
    times_seen: int
    first_seen_utc_ns: int
    last_seen_utc_ns: int
    hibernated_utc_ns: int


class Archive:
    """Objects that sleep, by id. An object taken out wakes; it may be put back."""

    def __init__(self) -> None:
        self._objects: dict[int, MapObject] = {}
        self._places = Columns(2, np.float64)
        self._ids = Columns(1, np.int64)
        self._near: NDArray[np.intp] = np.zeros(0, np.intp)
        self._near_centre = np.full(2, np.nan)
        self._near_reach = 0.0

    def __len__(self) -> int:
        return len(self._objects)

    def put(self, objects: list[MapObject]) -> None:
        """Add objects; one with the id of another replaces it."""
        if not objects:
            return
        self.remove([o.id for o in objects])
        self._objects |= {o.id: o for o in objects}
        self._places.append(np.array([o.position[:2] for o in objects], np.float64).T)
        self._ids.append(np.array([[o.id for o in objects]], np.int64))
        self._near_centre[:] = np.nan

    def remove(self, ids: list[int]) -> list[MapObject]:
        """Take objects out by id and return them; ids that are not here are passed over."""
        removed = [self._objects.pop(i) for i in ids if i in self._objects]
        if removed:
            gone = np.isin(self._ids.data[0], [o.id for o in removed])
            self._places.keep(~gone)
            self._ids.keep(~gone)
            self._near_centre[:] = np.nan
        return removed

    def places(self, centre: Array, distance: float) -> tuple[NDArray[np.int64], Array]:
        """Return ids (k,) and north-east positions (2, k) of the objects not farther than `distance` from (2,)."""
        if not self._objects:
            return np.zeros(0, np.int64), np.zeros((2, 0))
        moved = np.hypot(*(centre - self._near_centre))
        if not moved + distance <= self._near_reach:
            self._near_centre = centre.copy()
            self._near_reach = distance + SKIN_M
            self._near = np.flatnonzero(np.hypot(*(self._places.data - centre[:, None])) <= self._near_reach)
        if not len(self._near):
            return np.zeros(0, np.int64), np.zeros((2, 0))
        places = self._places.data[:, self._near]
        close = np.hypot(*(places - centre[:, None])) <= distance
        return self._ids.data[0, self._near[close]], places[:, close]

    def near(self, centre: Array, distance: float) -> list[MapObject]:
        """Return the objects not farther than `distance` from (2,)."""
        return [self._objects[i] for i in self.places(centre, distance)[0].tolist()]

    def all(self) -> list[MapObject]:
        """Return every object that is here."""
        return list(self._objects.values())
