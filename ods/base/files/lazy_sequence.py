"""A sequence whose items are made, or read, when they are asked for."""

import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar, overload

from ods.base.errors import OdsError

ItemT = TypeVar("ItemT")


class UnreadableItemError(OdsError):
    """One item cannot be read; others may be readable. The text is one line."""


class LazySequence(Sequence[ItemT], ABC):
    """Asking for an item that cannot be read raises UnreadableItemError; going through all leaves it out."""

    @abstractmethod
    def item(self, place: int) -> ItemT:
        """Return the item at 0 <= place < len(self)."""

    @overload
    def __getitem__(self, index: int) -> ItemT: ...

    @overload
    def __getitem__(self, index: slice) -> list[ItemT]: ...

    def __getitem__(self, index: int | slice) -> ItemT | list[ItemT]:
        """Return one item, or a list of some that leaves out the unreadable. Raises IndexError, UnreadableItemError."""
        if isinstance(index, slice):
            return list(self._readable(range(len(self))[index]))
        return self.item(range(len(self))[index])

    def __iter__(self) -> Iterator[ItemT]:
        """Yield those that can be read."""
        return self._readable(range(len(self)))

    def _readable(self, places: range) -> Iterator[ItemT]:
        for place in places:
            try:
                item = self.item(place)
            except UnreadableItemError:
                continue
            yield item


def place_after(items: Sequence[ItemT], value: float, key: Callable[[ItemT], int]) -> int:
    """Return the first place behind all items whose key is `value` or less; keys rise.

    Few items are asked for. What cannot be read counts as the next one that can.
    """

    def key_at(place: int) -> float:
        for at in range(place, len(items)):
            try:
                return key(items[at])
            except UnreadableItemError:
                continue
        return math.inf

    return bisect_right(range(len(items)), value, key=key_at)
