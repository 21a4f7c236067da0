"""Keeps the map file in step with the tracker; a file that fails costs the map, never the tracker."""

import math
from collections.abc import Callable, Iterable

import msgspec

from ods.tracker.map.hibernated import MapObject
from ods.tracker.map.store import ID_BLOCK, MapError, MapStore, open_map
from ods.tracker.settings import MapSettings


class MapKeeper:
    """Collects changes while the tracker works and writes them when there is time."""

    def __init__(
        self, settings: MapSettings, origin_deg: tuple[float, float], complain: Callable[[str, str], None]
    ) -> None:
        """`origin_deg`: latitude and longitude of the local frame; `complain` takes a counter's name and a line."""
        self.problem = ""
        """What is wrong with the file; empty when nothing is."""
        self._settings = settings
        self._origin_deg = origin_deg
        self._complain = complain
        self._store: MapStore | None = None
        self._put: dict[int, MapObject] = {}
        self._remove: set[int] = set()
        self._reserved = 1

    def open(self) -> tuple[list[MapObject], int]:
        """Return the objects of earlier missions and the first id for new ones."""
        if self._settings.path is None:
            return [], 1
        try:
            store = open_map(self._settings.path, *self._origin_deg)
            known, first_id = store.load(), store.first_free_id()
        except MapError as error:
            self._failed("map_unusable", error)
            return [], 1
        self._store = store
        self._reserved = first_id
        self.flush(first_id)
        return [self._older(o) for o in known], first_id

    def _older(self, known: MapObject) -> MapObject:
        """Return an object as far as it can be relied on in another mission, whose pose has other errors."""
        north, east = (math.hypot(s, self._settings.position_sigma_m) for s in known.sigma[:2])
        return msgspec.structs.replace(known, sigma=(north, east, known.sigma[2]))

    def note(self, hibernated: Iterable[MapObject], gone: Iterable[int]) -> None:
        """Take in what a step changed."""
        for o in hibernated:
            if not math.isfinite(sum((*o.position, *o.sigma, o.radius, o.sigma_radius, o.existence, o.covariance_ne))):
                self._complain("map_not_finite", f"object {o.id} is not finite and stays out of the map")
            elif o.times_seen >= self._settings.minimum_times_seen:
                self._put[o.id] = o
                self._remove.discard(o.id)
        for object_id in gone:
            self._put.pop(object_id, None)
            self._remove.add(object_id)

    def flush(self, next_id: int) -> None:
        """Write what was noted; keep ids reserved ahead of `next_id`."""
        if self._store is None:
            return
        try:
            if next_id + ID_BLOCK // 2 > self._reserved:
                self._store.reserve(next_id + ID_BLOCK)
                self._reserved = next_id + ID_BLOCK
            if self._put or self._remove:
                self._store.change(self._put.values(), self._remove)
        except MapError as error:
            self._failed("map_write_failed", error)
            return
        self._put, self._remove, self.problem = {}, set(), ""

    def close(self, next_id: int) -> None:
        """Write what is left, give back ids not used, and close the file."""
        self.flush(next_id)
        if self._store is None:
            return
        try:
            self._store.reserve(next_id)
        except MapError as error:
            self._failed("map_write_failed", error)
        self._store.close()

    def _failed(self, counter: str, error: MapError) -> None:
        self.problem = str(error)
        self._complain(counter, self.problem)
