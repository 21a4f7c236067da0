"""Messages received from the processes of a run folder."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import zmq

from ods.base import clock
from ods.messages import Clearance, Health, ObstacleList
from ods.runtime import bus
from ods.runtime.processes import SUPERVISOR, may_be_on_board, on_board

REFRESH_S = 0.25
LOOK_S = 2.5
"""Longest time for one snapshot, s: by then every running process has reported its health several times."""


@dataclass
class Received:
    """The newest of each."""

    newest: ObstacleList | None = None
    clear: Clearance | None = None
    health: dict[str, Health] = field(default_factory=dict)
    """By process."""

    def take(self, message: Any) -> None:
        """Keep a message."""
        if isinstance(message, Health):
            self.health[message.process] = message
        elif isinstance(message, Clearance):
            self.clear = message
        else:
            self.newest = message

    def silent(self, now_ns: int) -> bool:
        """Return whether there is no list that is new enough to be used."""
        return self.newest is None or age_s(self.newest, now_ns) > bus.TOPICS["obstacles"].stale_s

    def complete(self) -> bool:
        """Return whether everything that runs on every vehicle was received."""
        names = {process.name for process in on_board()}
        return self.newest is not None and self.clear is not None and names <= self.health.keys()


def age_s(newest: ObstacleList, now_ns: int) -> float:
    """Return how old a list is: that of a ping of a far range is made a second after its transmission."""
    return (now_ns - (newest.made_ns or newest.t_ns)) / clock.NS


def listen(run_dir: Path) -> Iterator[Received]:
    """Yield what has been received, at every message or REFRESH_S, without end. Raises RunDirError."""
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    names = [*(process.name for process in may_be_on_board()), SUPERVISOR]
    received = Received()
    with bus.Subscriber(context, run_dir, ["obstacles", "clearance"], names) as subscriber:
        while True:
            for _, message in subscriber.receive(REFRESH_S)[0]:
                received.take(message)
            yield received


def read_once(run_dir: Path) -> Received:
    """Return what is received until it is complete, LOOK_S at most. Raises RunDirError."""
    stop_ns = clock.monotonic_ns() + round(LOOK_S * clock.NS)
    return next(received for received in listen(run_dir) if received.complete() or clock.monotonic_ns() >= stop_ns)
