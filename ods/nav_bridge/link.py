"""Interface of every line to a navigation system."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

ItemT_co = TypeVar("ItemT_co", covariant=True)
Descriptor = Callable[[int | None], None]
"""Called with a descriptor to poll; None: there is none, its owner reads often."""


class Link(ABC, Generic[ItemT_co]):
    """A line that is opened, read, and opened again when it fails.

    Without a thread: its owner calls `read` when the descriptor passed to it is readable, and `tick` often.
    """

    @property
    @abstractmethod
    def is_open(self) -> bool:
        """Return whether the line is open."""

    @abstractmethod
    def tick(self) -> None:
        """Open the line when it is due, give it up when there is reason to. Raises OdsError for bad settings."""

    @abstractmethod
    def read(self, woken_ns: int) -> Iterator[ItemT_co]:
        """Yield what has arrived; `woken_ns`: when the first of it came, if nothing stamps it."""

    @abstractmethod
    def problems(self) -> list[str]:
        """Return the problems of the line, a text each."""

    @abstractmethod
    def close(self) -> None:
        """Close the line."""

    def send(self, can_id: int, data: bytes) -> None:
        """Send a standard CAN data frame; other lines are receive-only."""
