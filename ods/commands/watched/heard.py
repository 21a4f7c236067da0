"""What the processes of a run folder publish, as it is heard."""

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
"""One look takes no longer: every process that runs has told of its health several times."""


@dataclass
class Heard:
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
        """Return whether everything that runs on every vehicle was heard."""
        names = {process.name for process in on_board()}
        return self.newest is not None and self.clear is not None and names <= self.health.keys()


def age_s(newest: ObstacleList, now_ns: int) -> float:
    """Return how old a list is: that of a ping of a far range is made a second after its transmission."""
    return (now_ns - (newest.made_ns or newest.t_ns)) / clock.NS


def listen(run_dir: Path) -> Iterator[Heard]:
    """Yield what has been heard, at every message or REFRESH_S, without end. Raises RunDirError."""
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    names = [*(process.name for process in may_be_on_board()), SUPERVISOR]
    heard = Heard()
    with bus.Subscriber(context, run_dir, ["obstacles", "clearance"], names) as subscriber:
        while True:
            for _, message in subscriber.receive(REFRESH_S)[0]:
                heard.take(message)
            yield heard


def one_look(run_dir: Path) -> Heard:
    """Return what is heard until it is complete, LOOK_S at most. Raises RunDirError."""
    stop_ns = clock.monotonic_ns() + round(LOOK_S * clock.NS)
    return next(heard for heard in listen(run_dir) if heard.complete() or clock.monotonic_ns() >= stop_ns)
