"""`ods replay --live`: a recording onto the bus, as if its processes ran now."""

import time
from collections import Counter
from collections.abc import Callable, Collection, Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

import msgspec
import zmq

from ods.base import clock
from ods.base.command_line.terminal import StatusLine
from ods.base.errors import OdsError
from ods.recording.mcap.reader import Recorded
from ods.replay.player import Player
from ods.replay.timeline import Timeline
from ods.runtime import bus
from ods.runtime.run_dir import Lock

PROCESS = "replay"
REQUESTS = "replay-requests"
WARM_UP_S = 0.5
"""Subscribers that wait already need up to 0.2 s to find the new sockets; also between loops, be they ever so short."""


Messages = Callable[[Collection[str]], Iterable[Recorded]]
"""Gives the messages of some topics, as `Recording.messages` does; called again for each loop."""


class ReplayError(OdsError):
    """A recording cannot be replayed; the text is one line."""


class Wanted(NamedTuple):
    """What of a recording is played, and how."""

    speed: float = 1.0
    span_s: tuple[float, float] = (0.0, float("inf"))
    """From, to: of the recording, from its start."""
    loop: bool = False
    topics: Collection[str] = tuple(bus.TOPICS)
    """Those of the others may come from processes that run."""


class Played(NamedTuple):
    """The messages played."""

    messages: int
    losses: "Counter[str]"


def play(messages: Messages, run_dir: Path, wanted: Wanted) -> Played:
    """Publish a recording until its end, or without one; return what was published.

    Raises OdsError: a process of the recording runs on `run_dir`, there is nothing in the recording.
    """
    processes = frozenset(bus.TOPICS[topic].publisher for topic in wanted.topics)
    with ExitStack() as stack:
        status = StatusLine()
        stack.callback(status.clear)
        lock = Lock(run_dir, PROCESS)
        stack.callback(lock.close)
        context = stack.enter_context(zmq.Context())
        publishers = {}
        for name in sorted(processes):
            publishers[name] = bus.Publisher(context, run_dir, name)
            stack.callback(publishers[name].close)
        responder = bus.Responder(context, run_dir, REQUESTS)
        stack.callback(responder.close)

        def publish(process: str, topic: str, message: msgspec.Struct) -> None:
            publishers[process].publish(topic, message)

        player = Player(Timeline(wanted.speed, clock.utc_offset_ns()), publish, responder, status.show)
        while True:
            time.sleep(WARM_UP_S)
            before = player.published
            player.play(messages([*wanted.topics, bus.HEALTH]), wanted.span_s, processes)
            if player.published == before:
                raise ReplayError("there is nothing to replay in the recording")
            if not wanted.loop:
                return Played(player.published, player.losses)
