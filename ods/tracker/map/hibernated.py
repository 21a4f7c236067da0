"""Hibernated objects: kept out of the filters until the sonar observes their positions again.

Their places are in an R-tree. What it finds around the vehicle is kept, and the R-tree is queried again only when the
vehicle has moved on by `QUERY_MARGIN_M` (the neighbour list of molecular dynamics, after Verlet) or an object came or
went.
"""

import sqlite3
from collections.abc import Iterable

import msgspec
import numpy as np

from ods.base.arrays import Floats, Ints
from ods.pose.utc import Restamp
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.pending import PendingChanges
from ods.tracker.map.schema import INSIDE, PLACE_TABLE, square_around
from ods.tracker.restart.state import MapChanges

QUERY_MARGIN_M = 20.0
"""Distance that the vehicle may move before the R-tree is queried again, m."""


class HibernatedObjects:
    """Objects that sleep, by id, and what was known of those that are awake, until they sleep again or are gone."""

    def __init__(self, objects: Iterable[MapObject] = ()) -> None:
        self._objects: dict[int, MapObject] = {}
        self._awake: dict[int, MapObject] = {}
        self._tree = sqlite3.connect(":memory:", isolation_level=None, check_same_thread=False)
        self._tree.execute(PLACE_TABLE)
        self._changes = PendingChanges()
        """Since the last `whole`."""
        self._near_ids = np.zeros(0, np.int64)
        self._near_places = np.zeros((2, 0))
        self._near_centre = np.full(2, np.nan)
        self._near_reach = 0.0
        self.put(list(objects))

    def __len__(self) -> int:
        return len(self._objects)

    def ids(self) -> set[int]:
        """Return the ids of all objects of the map, asleep or awake."""
        return self._objects.keys() | self._awake.keys()

    def put(self, objects: list[MapObject]) -> None:
        """Add objects; one with the id of another replaces it."""
        rows = [(o.id, o.position[0], o.position[0], o.position[1], o.position[1]) for o in objects]
        self._tree.executemany("INSERT OR REPLACE INTO place VALUES (?, ?, ?, ?, ?)", rows)
        self._objects |= {o.id: o for o in objects}
        self._near_centre[:] = np.nan
        self._note(objects)

    def wake(self, ids: list[int]) -> list[MapObject]:
        """Remove objects by id and return them; unknown ids are ignored."""
        woken = [self._objects.pop(i) for i in ids if i in self._objects]
        self._tree.executemany("DELETE FROM place WHERE id = ?", [(o.id,) for o in woken])
        self._near_centre[:] = np.nan
        self._awake |= {o.id: o for o in woken}
        return woken

    def remember(self, awake: list[MapObject]) -> None:
        """Keep what is known of objects that are awake but belong in the map."""
        self._awake |= {o.id: o for o in awake}
        self._note(awake)

    def sleep(self, ids: list[int], existences: list[float]) -> None:
        """Put objects back that are awake, as they were known, with their present existence."""
        known = [self._awake.pop(i) for i in ids]
        self.put([msgspec.structs.replace(o, existence=p) for o, p in zip(known, existences, strict=True)])

    def sleep_all(self) -> None:
        """Put all objects back that are awake, as they were known."""
        known, self._awake = list(self._awake.values()), {}
        self.put(known)

    def restamp(self, moved: Restamp) -> list[MapObject]:
        """Follow a step of UTC; return the objects that it changed."""
        changed = []
        for objects in (self._objects, self._awake):
            for o in objects.values():
                stamps = o.first_seen_utc_ns, o.last_seen_utc_ns, o.hibernated_utc_ns
                first, last, hibernated = map(moved.of, stamps)
                if (first, last, hibernated) != stamps:
                    changed.append(
                        msgspec.structs.replace(
                            o, first_seen_utc_ns=first, last_seen_utc_ns=last, hibernated_utc_ns=hibernated
                        )
                    )
        for o in changed:
            (self._objects if o.id in self._objects else self._awake)[o.id] = o
        self._note(changed)
        return changed

    def forget(self, ids: list[int]) -> None:
        """Objects are gone, those that sleep too."""
        if not self._objects.keys().isdisjoint(ids):
            self.wake(ids)
        for i in ids:
            if self._awake.pop(i, None) is not None:
                self._changes.remove(i)

    def changes(self) -> MapChanges:
        """Return how the objects, asleep or awake, differ from the last `whole`."""
        return MapChanges(list(self._changes.puts.values()), list(self._changes.removes))

    def whole(self) -> list[MapObject]:
        """Return all objects, asleep or awake; `changes` start again."""
        self._changes = PendingChanges()
        return [*self._objects.values(), *self._awake.values()]

    def _note(self, objects: list[MapObject]) -> None:
        for o in objects:
            self._changes.put(o)

    def places(self, centre: Floats, distance: float) -> tuple[Ints, Floats]:
        """Return ids (k,) and north-east positions (2, k) of the objects not farther than `distance` from (2,)."""
        if not np.hypot(*(centre - self._near_centre)) + distance <= self._near_reach:
            self._look_around(centre, distance + QUERY_MARGIN_M)
        close = np.hypot(*(self._near_places - centre[:, None])) <= distance
        return self._near_ids[close], self._near_places[:, close]

    def near(self, centre: Floats, distance: float) -> list[MapObject]:
        """Return the objects not farther than `distance` from (2,)."""
        return [self._objects[i] for i in self.places(centre, distance)[0].tolist()]

    def all(self) -> list[MapObject]:
        """Return every object that is here."""
        return list(self._objects.values())

    def _look_around(self, centre: Floats, reach: float) -> None:
        """Ask the R-tree what is within `reach`."""
        square = square_around(float(centre[0]), float(centre[1]), reach)
        ids = [row[0] for row in self._tree.execute(f"SELECT id FROM place WHERE {INSIDE}", square)]
        self._near_ids = np.array(ids, np.int64)
        self._near_places = np.array([self._objects[i].position[:2] for i in ids], np.float64).reshape(-1, 2).T
        self._near_centre, self._near_reach = centre.copy(), reach
