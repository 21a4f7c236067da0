"""Messages that wait for the disk: a queue, bounded by their bytes, between the bus and the thread that writes."""

import threading
from collections import deque
from typing import NamedTuple


class Received(NamedTuple):
    """One message as it came."""

    topic: str
    log_ns: int
    """CLOCK_MONOTONIC."""
    data: bytes


class Inbox:
    """Takes messages without waiting; when it is full the oldest are dropped and counted."""

    def __init__(self, most_bytes: int) -> None:
        self.dropped = 0
        self._most = most_bytes
        self._bytes = 0
        self._waiting: deque[Received] = deque()
        self._changed = threading.Condition()
        self._closed = False

    def put(self, messages: list[Received]) -> None:
        """Add messages."""
        with self._changed:
            self._waiting += messages
            self._bytes += sum(len(message.data) for message in messages)
            while self._bytes > self._most:
                self._bytes -= len(self._waiting.popleft().data)
                self.dropped += 1
            self._changed.notify()

    def take(self, within_s: float) -> list[Received]:
        """Return the waiting messages as soon as there are any; none after this time, or when it is closed."""
        with self._changed:
            if not self._waiting and not self._closed:
                self._changed.wait(within_s)
            taken, self._waiting, self._bytes = list(self._waiting), deque(), 0
            return taken

    def close(self) -> None:
        """Signal that no more messages follow."""
        with self._changed:
            self._closed = True
            self._changed.notify()

    @property
    def ended(self) -> bool:
        """Nothing waits, and nothing more comes."""
        with self._changed:
            return self._closed and not self._waiting
