"""What a connection may take before it has shown a token: a head of bounded size within bounded time.

uvicorn bounds neither the time of a request's head nor the number of connections; its other parser, httptools, not the
head's size.
"""

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

MOST_HEAD_BYTES = 1 << 16
"""Cookies of several workbenches on one address are a few hundred."""
MOST_CONNECTIONS = 200
"""A page has about ten. Of more, the oldest goes that waits for a head."""
PATIENCE_S = 10.0
"""For a whole head, from its first byte or the connection's beginning on."""


class BoundedProtocol(H11Protocol):
    """One HTTP connection."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._timer: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn's own
        """Wait for the first head; make room for it."""
        super().connection_made(transport)
        self._begin_waiting()
        waiting = [each for each in self.connections if isinstance(each, BoundedProtocol) and each._timer is not None]
        if len(self.connections) > MOST_CONNECTIONS:
            min(waiting, key=lambda each: each._deadline_s())._give_up()

    def data_received(self, data: bytes) -> None:
        """Take bytes; wait for the rest of a head that they begin."""
        super().data_received(data)
        if self.conn.their_state is not h11.IDLE:
            self._end_waiting()
        elif self._timer is None:
            self._begin_waiting()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self._end_waiting()
        super().connection_lost(exc)

    def _begin_waiting(self) -> None:
        self._timer = self.loop.call_later(PATIENCE_S, self._give_up)

    def _end_waiting(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _deadline_s(self) -> float:
        return self._timer.when() if self._timer is not None else float("inf")

    def _give_up(self) -> None:
        self._end_waiting()
        self.transport.abort()
