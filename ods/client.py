"""For path planners: the obstacle list, as it comes, with a word of its own when it stays away; and the sonar's range.

from ods.client import Obstacles

for picture in Obstacles("/run/ods"):
    if not picture.valid:
        print("do not rely on it:", picture.reasons)
    for obstacle in picture.obstacles:
        print(obstacle.id, obstacle.state, obstacle.position_ned, obstacle.radius_m)

Sonar("/run/ods").set_range(50.0)
"""

import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import zmq

from ods.base import clock
from ods.base.errors import OdsError
from ods.messages import ClosestApproach, Obstacle, ObstacleList, Prediction, SonarAnswer, SonarRequest, UnseenPart
from ods.runtime import bus
from ods.runtime.processes import SUPERVISOR

__all__ = [
    "ClosestApproach", "Obstacle", "ObstacleList", "Obstacles", "Prediction", "Sonar", "SonarAnswer", "SonarError",
    "SonarRequest", "UnseenPart",
]  # fmt: skip


class Obstacles:
    """Iterates over obstacle lists, newest first lost never: each call of next() returns the newest list.

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
            for _, message in reversed(self._subscriber.receive(left_s)[0]):
                if isinstance(message, ObstacleList):
                    self._last, self._last_ns, self._why = message, clock.monotonic_ns(), ""
                    return message
                if message.process == "tracker":
                    self._why = "; " + "; ".join(message.problems)
        return self._silence()

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


class Sonar:
    """Asks the sonar process to set the sonar. What is asked for lasts until the next request."""

    def __init__(self, run_dir: str | Path, timeout_s: float = 6.0) -> None:
        """`timeout_s`: how long each request may take; the sonar process itself gives up after 4 s by default."""
        self._timeout_s = timeout_s
        self._run_dir = Path(run_dir)
        self._decoder = msgspec.msgpack.Decoder(SonarAnswer)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._socket = self._context.socket(zmq.REQ)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.IMMEDIATE, 1)  # a request never waits for a process that is away
        self._socket.setsockopt(zmq.REQ_RELAXED, 1)  # the next one may be sent though this one was not answered
        self._socket.setsockopt(zmq.REQ_CORRELATE, 1)
        self._socket.setsockopt(zmq.SNDTIMEO, round(timeout_s * 1000))
        self._socket.setsockopt(zmq.RCVTIMEO, round(timeout_s * 1000))
        self._socket.connect(bus.endpoint(self._run_dir, "sonar-requests"))

    def set_range(self, range_m: float) -> SonarAnswer:
        """Set the range, m; return when the sonar works with it. Raises SonarError."""
        return self.ask(SonarRequest(range_m=range_m))

    def ask(self, request: SonarRequest) -> SonarAnswer:
        """Send any request, wait for its answer. Raises SonarError when it is not ok, or none comes in time."""
        try:
            self._socket.send(msgspec.msgpack.encode(request))
            answer = self._decoder.decode(self._socket.recv())
        except zmq.Again:
            why = bus.hindrance(self._run_dir, "sonar-requests") or ": does it run?"
            raise SonarError(f"no answer from the sonar process within {self._timeout_s:g} s{why}") from None
        except msgspec.DecodeError as error:
            raise SonarError(f"bad answer from the sonar process: {error}") from None
        if not answer.ok:
            raise SonarError(answer.reason)
        return answer

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()
        self._context.term()
