"""Obstacle lists as they arrive, and a list marked not valid if none arrives."""

import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import zmq

from ods.base import clock
from ods.base.errors import OdsError
from ods.client.extrapolation import ExtrapolatedObstacle, at
from ods.client.remote import SCHEME, RemoteBus
from ods.messages import Health, ObstacleList
from ods.runtime import bus
from ods.runtime.processes import SUPERVISOR
from ods.runtime.run_dir import RunDirError

_Source = bus.Subscriber | RemoteBus


class NoListError(OdsError):
    """No obstacle list has been received yet, so nothing is known about obstacles."""


class Obstacles:
    """Iterates over obstacle lists: each call of next() returns the newest one, however long ago the last call was.

    After `stale_s` without a list, for example because the tracker has stopped, the last list is returned again with
    `valid` false.
    """

    def __init__(
        self,
        place: str | Path,
        stale_s: float = bus.TOPICS["obstacles"].stale_s,
        *,
        key: str | Path | None = None,
    ) -> None:
        """`place`: the run folder, or on another computer "tcp://ADDRESS:PORT", with the file of a `key`.

        `stale_s`: longest wait for a list, and largest age of a valid one.

        Raises KeyFileError for an unusable key, RemoteError for an invalid address.
        """
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._place = place
        self._subscriber = self._opened(place, key)
        self._stale_s = stale_s
        self._last: ObstacleList | None = None
        self._last_ns = clock.monotonic_ns()
        self._why = ""

    def _opened(self, place: str | Path, key: str | Path | None) -> _Source:
        if str(place).startswith(SCHEME):
            return RemoteBus(self._context, str(place), key)
        return bus.Subscriber(self._context, Path(place), ["obstacles"], [SUPERVISOR])

    def __iter__(self) -> Iterator[ObstacleList]:
        while True:
            yield self.next()

    def next(self) -> ObstacleList:
        """Return the newest list; wait for it `stale_s` at most."""
        deadline_s = time.monotonic() + self._stale_s
        while (left_s := deadline_s - time.monotonic()) > 0.0:
            for _, message in reversed(self._received(left_s)):
                if isinstance(message, ObstacleList):
                    now = clock.monotonic_ns()
                    self._last, self._last_ns = message, self._made_ns(message, now)
                    if now - self._last_ns > self._stale_s * clock.NS:
                        break  # not read for a long time: a full queue keeps the oldest, newer lists follow
                    self._why = ""
                    if isinstance(self._subscriber, RemoteBus):
                        self._subscriber.worked(now)
                    return message
                if message.process == "tracker":
                    self._why = "; " + "; ".join(message.problems)
        return self._silence()

    def _made_ns(self, message: ObstacleList, now_ns: int) -> int:
        """Return when a list was made, by the clock of this computer."""
        if isinstance(self._subscriber, RemoteBus):
            return now_ns - self._subscriber.age_ns(message)
        return message.made_ns or now_ns

    def _received(self, timeout_s: float) -> list[tuple[str, ObstacleList | Health]]:
        try:
            return self._subscriber.receive(timeout_s)[0]
        except RunDirError as error:  # any user could publish there
            self._why = f"; {error}"
            return []

    def at(self, t_ns: int) -> list[ExtrapolatedObstacle]:
        """Return the obstacles of the newest list, extrapolated to `t_ns`. Raises NoListError.

        `t_ns` is CLOCK_MONOTONIC of the computer where the list was made; with UTC use `ods.client.at`. The result does
        not depend on whether that list is valid, or how old it is.
        """
        if self._last is None:
            raise NoListError("no obstacle list received yet")
        return at(self._last, t_ns)

    def _silence(self) -> ObstacleList:
        now = clock.monotonic_ns()
        silent_s = (now - self._last_ns) / clock.NS
        why = self._why or self._unreachable_reason()
        reason = f"tracker: no obstacle list for {silent_s:.1f} s{why}"
        if self._last is None:
            return ObstacleList(0, -1, now, clock.utc_ns(now), 0, False, [reason], [])
        return msgspec.structs.replace(self._last, valid=False, reasons=[reason])

    def _unreachable_reason(self) -> str:
        if isinstance(self._subscriber, RemoteBus):
            return self._subscriber.unreachable_reason()
        return bus.unreachable_reason(Path(self._place), "tracker")

    def close(self) -> None:
        """Close the connection."""
        self._subscriber.close()
        self._context.term()
