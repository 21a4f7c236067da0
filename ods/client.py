"""For path planners: the obstacle list, as it comes, with a word of its own when it stays away; and the sonar's range.

from ods.client import Obstacles

for picture in Obstacles("/run/ods"):
    if not picture.valid:
        print("do not rely on it:", picture.reasons)
    for obstacle in picture.obstacles:
        print(obstacle.id, obstacle.state, obstacle.position_ned, obstacle.radius_m)

Sonar("/run/ods").set_range(50.0)
Replay("/run/ods").step()
"""

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Generic, TypeVar

import msgspec
import zmq

from ods.base import clock
from ods.base.errors import OdsError
from ods.messages import (
    ClosestApproach,
    Health,
    Obstacle,
    ObstacleList,
    Prediction,
    ReplayAnswer,
    ReplayRequest,
    SonarAnswer,
    SonarRequest,
    UnseenPart,
)
from ods.runtime import bus
from ods.runtime.processes import SUPERVISOR
from ods.runtime.run_dir import RunDirError, is_safe_to_hear

__all__ = [
    "ClosestApproach", "Obstacle", "ObstacleList", "Obstacles", "Prediction", "Replay", "ReplayAnswer", "ReplayError",
    "ReplayRequest", "Sonar", "SonarAnswer", "SonarError", "SonarRequest", "UnseenPart",
]  # fmt: skip

RequestT = TypeVar("RequestT", bound=msgspec.Struct)
AnswerT = TypeVar("AnswerT", SonarAnswer, ReplayAnswer)


class Obstacles:
    """Iterates over obstacle lists: each call of next() returns the newest one, however long nobody called.

    A tracker that is gone cannot say so; after `stale_s` of silence the last list is given again, marked not valid.
    """

    def __init__(self, run_dir: str | Path, stale_s: float = bus.TOPICS["obstacles"].stale_s) -> None:
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._run_dir = Path(run_dir)
        self._subscriber = bus.Subscriber(self._context, self._run_dir, ["obstacles"], [SUPERVISOR])
        self._stale_s = stale_s
        self._last: ObstacleList | None = None
        self._last_ns = clock.monotonic_ns()
        self._why = ""

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
                    self._last, self._last_ns = message, message.made_ns or now
                    if now - self._last_ns > self._stale_s * clock.NS:
                        break  # nobody read for long: a full queue keeps the oldest, newer lists are on their way
                    self._why = ""
                    return message
                if message.process == "tracker":
                    self._why = "; " + "; ".join(message.problems)
        return self._silence()

    def _received(self, timeout_s: float) -> list[tuple[str, ObstacleList | Health]]:
        try:
            return self._subscriber.receive(timeout_s)[0]
        except RunDirError as error:  # who speaks there may be anybody
            self._why = f"; {error}"
            return []

    def _silence(self) -> ObstacleList:
        now = clock.monotonic_ns()
        silent_s = (now - self._last_ns) / clock.NS
        why = self._why or bus.hindrance(self._run_dir, "tracker")
        reason = f"tracker: no obstacle list for {silent_s:.1f} s{why}"
        if self._last is None:
            return ObstacleList(0, -1, now, clock.utc_ns(now), 0, False, [reason], [])
        return msgspec.structs.replace(self._last, valid=False, reasons=[reason])

    def close(self) -> None:
        """Give the socket back."""
        self._subscriber.close()
        self._context.term()


class SonarError(OdsError):
    """The sonar does not work as asked; the text says why in one line."""


class ReplayError(OdsError):
    """A live replay does not do as asked; the text says why in one line."""


class _Asker(Generic[RequestT, AnswerT]):
    """Asks on one of the sockets for requests."""

    def __init__(self, run_dir: Path, row: str, answer: type[AnswerT], timeout_s: float) -> None:
        self._run_dir, self._row, self._timeout_s = run_dir, bus.REQUESTS[row], timeout_s
        self._decoder: msgspec.msgpack.Decoder[AnswerT] = msgspec.msgpack.Decoder(answer)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._socket = self._context.socket(zmq.REQ)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.IMMEDIATE, 1)  # a request never waits for a process that is away
        self._socket.setsockopt(zmq.REQ_RELAXED, 1)  # the next one may be sent though this one was not answered
        self._socket.setsockopt(zmq.REQ_CORRELATE, 1)
        self._socket.setsockopt(zmq.SNDTIMEO, round(timeout_s * 1000))
        self._socket.setsockopt(zmq.RCVTIMEO, round(timeout_s * 1000))
        self._socket.connect(bus.endpoint(run_dir, row))

    def ask(self, request: RequestT, error: type[OdsError]) -> AnswerT:
        """Send a request, wait for its answer. Raises `error` when it is not ok, or none comes in time."""
        process = f"{self._row.process} process"
        try:
            is_safe_to_hear(self._run_dir)
            self._socket.send(msgspec.msgpack.encode(request))
            answer = self._decoder.decode(self._socket.recv())
        except RunDirError as unsafe:
            raise error(str(unsafe)) from None
        except zmq.Again:
            why = bus.hindrance(self._run_dir, self._row.name) or ": does it run?"
            raise error(f"no answer from the {process} within {self._timeout_s:g} s{why}") from None
        except msgspec.DecodeError as wrong:
            raise error(f"bad answer from the {process}: {wrong}") from None
        if not answer.ok:
            raise error(answer.reason)
        return answer

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()
        self._context.term()


class Sonar:
    """Asks the sonar process to set the sonar. What is asked for lasts until the next request."""

    def __init__(self, run_dir: str | Path, timeout_s: float = 6.0) -> None:
        """`timeout_s`: how long each request may take; the sonar process itself gives up after 4 s by default."""
        self._asker: _Asker[SonarRequest, SonarAnswer] = _Asker(Path(run_dir), "sonar-requests", SonarAnswer, timeout_s)

    def set_range(self, range_m: float) -> SonarAnswer:
        """Set the range, m; return when the sonar works with it. Raises SonarError."""
        return self.ask(SonarRequest(range_m=range_m))

    def ask(self, request: SonarRequest) -> SonarAnswer:
        """Send any request, wait for its answer. Raises SonarError when it is not ok, or none comes in time."""
        return self._asker.ask(request, SonarError)

    def close(self) -> None:
        """Give the socket back."""
        self._asker.close()


class Replay:
    """Asks a live replay to pause, to go on, to step."""

    def __init__(self, run_dir: str | Path, timeout_s: float = 2.0) -> None:
        """`timeout_s`: how long each request may take."""
        self._asker: _Asker[ReplayRequest, ReplayAnswer] = _Asker(
            Path(run_dir), "replay-requests", ReplayAnswer, timeout_s
        )

    def pause(self) -> ReplayAnswer:
        """Stop after the message that was published last. Raises ReplayError."""
        return self.ask(ReplayRequest(do="pause"))

    def go(self, speed: float | None = None) -> ReplayAnswer:
        """Go on. Raises ReplayError."""
        return self.ask(ReplayRequest(do="go", speed=speed))

    def step(self, steps: int = 1) -> ReplayAnswer:
        """Go on until so many obstacle lists have been published, then pause. Raises ReplayError."""
        return self.ask(ReplayRequest(do="step", steps=steps))

    def ask(self, request: ReplayRequest) -> ReplayAnswer:
        """Send any request, wait for its answer. Raises ReplayError when it is not ok, or none comes in time."""
        return self._asker.ask(request, ReplayError)

    def close(self) -> None:
        """Give the socket back."""
        self._asker.close()
