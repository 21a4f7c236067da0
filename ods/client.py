"""For path planners: the obstacle list, as it comes, with a word of its own when it stays away.

from ods.client import Obstacles

for picture in Obstacles("/tmp/ods"):
    if not picture.valid:
        print("do not rely on it:", picture.reasons)
    for obstacle in picture.obstacles:
        print(obstacle.id, obstacle.state, obstacle.position_ned, obstacle.radius_m)
"""

from collections.abc import Iterator
from pathlib import Path

import msgspec
import zmq

from ods import bus, clock
from ods.messages import ClosestApproach, Obstacle, ObstacleList, Prediction

__all__ = ["ClosestApproach", "Obstacle", "ObstacleList", "Obstacles", "Prediction"]


class Obstacles:
    """Iterates over obstacle lists, newest first lost never: each call of next() returns the newest list.

    A tracker that is gone cannot say so; after `stale_s` of silence the last list is given again, marked not valid.
    """

    def __init__(self, run_dir: str | Path, stale_s: float = bus.TOPICS["obstacles"].stale_s) -> None:
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._subscriber = bus.Subscriber(self._context, Path(run_dir), ["obstacles"])
        self._stale_s = stale_s
        self._last: ObstacleList | None = None
        self._last_ns = clock.monotonic_ns()

    def __iter__(self) -> Iterator[ObstacleList]:
        while True:
            yield self.next()

    def next(self) -> ObstacleList:
        """Wait for the next list, at most `stale_s`."""
        received, _ = self._subscriber.receive(self._stale_s)
        if received:
            self._last = received[-1][1]
            self._last_ns = clock.monotonic_ns()
            return self._last
        return self._silence()

    def _silence(self) -> ObstacleList:
        now = clock.monotonic_ns()
        reason = f"tracker: no obstacle list for {(now - self._last_ns) / clock.NS:.1f} s"
        if self._last is None:
            return ObstacleList(0, -1, now, clock.utc_ns(now), 0, False, [reason], [])
        return msgspec.structs.replace(self._last, valid=False, reasons=[reason])

    def close(self) -> None:
        """Give the socket back."""
        self._subscriber.close()
        self._context.term()
