"""Changes not yet written: the newest state of each object, however long the disk takes."""

from collections.abc import Iterator
from itertools import islice

from ods.tracker.map.link import OBJECTS_A_PACKET, Change
from ods.tracker.map.map_object import MapObject


class PendingChanges:
    """Objects to put and ids to remove; never more than there are objects."""

    def __init__(self) -> None:
        self.puts: dict[int, MapObject] = {}
        """Objects that the file does not have yet, as they are."""
        self.removes: set[int] = set()
        """Ids of objects that the file may have and shall not."""

    def __bool__(self) -> bool:
        return bool(self.puts or self.removes)

    def __len__(self) -> int:
        return len(self.puts) + len(self.removes)

    def put(self, known: MapObject) -> None:
        """The file shall have this object."""
        self.puts[known.id] = known
        self.removes.discard(known.id)

    def remove(self, object_id: int) -> None:
        """The file shall not have this object."""
        self.puts.pop(object_id, None)
        self.removes.add(object_id)

    def first(self) -> Change:
        """Return as many changes as go into a packet."""
        return next(self.all(), Change([], []))

    def all(self) -> Iterator[Change]:
        """Return all changes, packet by packet."""
        put, remove = iter(self.puts.values()), iter(self.removes)
        while True:
            change = Change(list(islice(put, OBJECTS_A_PACKET)), list(islice(remove, OBJECTS_A_PACKET)))
            if not change.put and not change.remove:
                return
            yield change

    def written(self, change: Change) -> None:
        """Forget what the file has now; what changed again since then remains."""
        for known in change.put:
            if self.puts.get(known.id) is known:
                del self.puts[known.id]
        self.removes.difference_update(change.remove)
