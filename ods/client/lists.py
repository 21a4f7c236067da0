"""The obstacle list as it comes, with a word of its own when it stays away."""

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
    """No obstacle list came yet: nothing can be said of obstacles, nor that there are none."""


class Obstacles:
    """Iterates over obstacle lists: each call of next() returns the newest one, whatever the time since the last call.

    A tracker that is gone cannot say so; after `stale_s` of silence the last list is given again, marked not valid.
    """

    def __init__(
        self,
        place: str | Path,
        stale_s: float = bus.TOPICS["obstacles"].stale_s,
        *,
        key: str | Path | None = None,
    ) -> None:
        """`place`: the run folder, or on another computer "tcp://ADDRESS:PORT", with the file of a `key`.

        Raises KeyFileError for a key that cannot be used, RemoteError for an invalid address.
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
        """Wait for the next list, at most `stale_s`."""
        deadline_s = time.monotonic() + self._stale_s
        while (left_s := deadline_s - time.monotonic()) > 0.0:
            for _, message in reversed(self._received(left_s)):
                if isinstance(message, ObstacleList):
                    now = clock.monotonic_ns()
                    self._last, self._last_ns = message, self._made_ns(message, now)
                    if now - self._last_ns > self._stale_s * clock.NS:
                        break  # not read for long: a full queue keeps the oldest, newer lists are on their way
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
        except RunDirError as error:  # who speaks there may be anybody
            self._why = f"; {error}"
            return []

    def at(self, t_ns: int) -> list[ExtrapolatedObstacle]:
        """Return where the obstacles of the newest list that came are at `t_ns`, CLOCK_MONOTONIC. Raises NoListError.

        It is the clock of the computer where the list was made; `ods.client.at` has the way by UTC. They say nothing of
        whether that list is valid, nor of how old it is.
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
        """Give the socket back."""
        self._subscriber.close()
        self._context.term()
