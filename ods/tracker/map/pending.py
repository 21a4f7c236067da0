"""Changes not yet in the map file: the newest state of each object, however long the disk takes."""

from collections.abc import Iterator
from itertools import islice

from ods.tracker.map.link import OBJECTS_A_PACKET, Change
from ods.tracker.map.map_object import MapObject


class PendingChanges:
    """Objects to put and ids to remove; never more than there are objects."""

    def __init__(self) -> None:
        self._put: dict[int, MapObject] = {}
        self._remove: set[int] = set()

    def __bool__(self) -> bool:
        return bool(self._put or self._remove)

    def __len__(self) -> int:
        return len(self._put) + len(self._remove)

    def put(self, known: MapObject) -> None:
        """The file shall have this object."""
        self._put[known.id] = known
        self._remove.discard(known.id)

    def remove(self, object_id: int) -> None:
        """The file shall not have this object."""
        self._put.pop(object_id, None)
        self._remove.add(object_id)

    def puts(self) -> list[int]:
        """Return the ids of objects that the file does not have yet, as they are."""
        return list(self._put)

    def removes(self) -> list[int]:
        """Return the ids of objects that the file may have and shall not."""
        return list(self._remove)

    def first(self) -> Change:
        """Return as many changes as go into a packet."""
        return next(self.all(), Change([], []))

    def all(self) -> Iterator[Change]:
        """Return all changes, packet by packet."""
        put, remove = iter(self._put.values()), iter(self._remove)
        while True:
            change = Change(list(islice(put, OBJECTS_A_PACKET)), list(islice(remove, OBJECTS_A_PACKET)))
            if not change.put and not change.remove:
                return
            yield change

    def written(self, change: Change) -> None:
        """Forget what the file has now; what changed again since then remains."""
        for known in change.put:
            if self._put.get(known.id) is known:
                del self._put[known.id]
        self._remove.difference_update(change.remove)
