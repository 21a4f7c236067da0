"""Bounds on connections and headers that have shown no right yet, which any program can send.

Whoever has the workbench's cookie is not bounded; who has not is answered before a body is read.
"""

import asyncio
import logging
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

MOST_HEAD_BYTES = 64 << 10
"""Of a request's first line and headers; cookies of several workbenches on one address are a few hundred."""
MOST_CONNECTIONS = 200
"""That wait for a request: one more ends the oldest, as a browser sends its own at once."""
PATIENCE_S = 10.0
"""For a request's last header, from the connection or the last answer on."""


class BoundedProtocol(H11Protocol):
    """HTTP/1.1 on one connection. h11 itself bounds headers; uvicorn bounds no time before the first request."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for a request."""
        super().connection_made(transport)
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget it."""
        self._wait_no_more()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Take bytes, which may complete a request."""
        super().data_received(data)
        if self._answering:
            self._wait_no_more()

    def on_response_complete(self) -> None:
        """Wait for the next request, if it is not there already."""
        super().on_response_complete()
        if not self._answering:
            self._wait()

    def handle_websocket_upgrade(self, event: Any) -> None:
        """Hand the connection on: its request is whole."""
        self._wait_no_more()
        super().handle_websocket_upgrade(event)

    @property
    def _answering(self) -> bool:
        return self.cycle is not None and not self.cycle.response_complete

    def _wait(self) -> None:
        self._wait_no_more()
        if self.transport.is_closing():
            return
        _WAITING[self] = self.loop.call_later(PATIENCE_S, self.transport.abort)
        if len(_WAITING) > MOST_CONNECTIONS:
            next(iter(_WAITING)).transport.abort()

    def _wait_no_more(self) -> None:
        timer = _WAITING.pop(self, None)
        if timer is not None:
            timer.cancel()


_WAITING: dict[BoundedProtocol, asyncio.TimerHandle] = {}
"""All that wait, the longest first."""


def not_a_strangers_fault(record: logging.LogRecord) -> bool:
    """Return whether uvicorn's record is logged: what strangers send that is no HTTP would fill the terminal."""
    return not record.getMessage().startswith("Invalid HTTP request")
