"""Plays a recording in its own time: publishes each message when it is due, and does as it is asked meanwhile."""

import time
from collections import Counter
from collections.abc import Callable, Iterable
from typing import Any, Protocol

import msgspec

from ods.base import clock
from ods.base.clock import NS
from ods.messages import Health, ReplayAnswer, ReplayRequest
from ods.recording.mcap.reader import Recorded
from ods.replay.timeline import Timeline, moved
from ods.runtime import bus

STEP_TOPIC = "obstacles"
LONGEST_WAIT_S = 0.02
"""Between two looks for requests."""
STATUS_PERIOD_NS = NS // 4
LONGEST_GAP_NS = 60 * NS
"""Longer silence is skipped, as is the time between two starts of the computer: each has a clock of its own."""

Publish = Callable[[str, str, msgspec.Struct], None]
"""Process, topic, message."""


class Requests(Protocol):
    """A `bus.Responder`, or what stands for one."""

    def receive(self) -> list[tuple[list[bytes], Any]]:
        """Return whom to answer, and requests."""

    def answer(self, peer: list[bytes], message: msgspec.Struct) -> None:
        """Answer one."""


class Player:
    """Plays messages. `losses`: what could not be published, and how often."""

    def __init__(self, line: Timeline, publish: Publish, requests: Requests, report: Callable[[str], None]) -> None:
        """`report` gets a line of status now and then."""
        self.losses: Counter[str] = Counter()
        self.published = 0
        self.paused = False
        self._line, self._publish, self._requests, self._report = line, publish, requests, report
        self._steps = 0
        self._anew = True
        """The next message is due at once, whatever was before it."""
        self._at_ns = 0
        self._reported_ns = 0

    def play(self, messages: Iterable[Recorded], span_s: tuple[float, float], processes: frozenset[str]) -> None:
        """Publish what `processes` published, from one second of the recording to another."""
        self._anew = True
        after_ns, last_ns = 0, None
        for recorded in messages:
            step_ns = recorded.log_ns - last_ns if last_ns is not None else 0
            last_ns = recorded.log_ns
            if 0 <= step_ns <= LONGEST_GAP_NS:
                after_ns += step_ns
            else:
                self._anew = True
            if after_ns > span_s[1] * NS:
                return
            if after_ns >= span_s[0] * NS:
                self._take(recorded, after_ns, processes)

    def _take(self, recorded: Recorded, after_ns: int, processes: frozenset[str]) -> None:
        try:
            message = recorded.message()
        except ValueError:
            self.losses[f"bad_{recorded.topic}"] += 1
            return
        process = message.process if isinstance(message, Health) else bus.TOPICS[recorded.topic].publisher
        if process not in processes:
            return
        self._wait_for(recorded.log_ns)
        try:
            now = moved(message, self._line, recorded.utc_ns - recorded.log_ns)
        except ValueError:
            self.losses[f"bad_{recorded.topic}"] += 1
            return
        self._publish(process, recorded.topic, now)
        self.published += 1
        self._at_ns = after_ns
        if recorded.topic == STEP_TOPIC and self._steps:
            self._steps -= 1
            self.paused = not self._steps

    def _wait_for(self, recorded_ns: int) -> None:
        """Return when a recorded instant is now."""
        while True:
            for peer, request in self._requests.receive():
                self._follow(request)
                self._requests.answer(peer, self._answer())
            now_ns = clock.monotonic_ns()
            self._status(now_ns)
            if self.paused:
                self._anew = True
                time.sleep(LONGEST_WAIT_S)
                continue
            if self._anew:
                self._anew = False
                self._line.begin(recorded_ns, now_ns)
            wait_s = (self._line.at(recorded_ns) - now_ns) / NS
            if wait_s <= 0.0:
                return
            time.sleep(min(wait_s, LONGEST_WAIT_S))

    def _follow(self, request: ReplayRequest) -> None:
        if request.do != "tell":
            self.paused = request.do == "pause"
            self._steps = request.steps if request.do == "step" else 0
        if request.speed is not None and request.speed != self._line.speed:
            self._line.speed = request.speed
            self._anew = True

    def _answer(self) -> ReplayAnswer:
        return ReplayAnswer(
            ok=True, reason="", paused=self.paused, at_s=self._at_ns / NS, speed=self._line.speed,
            published=self.published,
        )  # fmt: skip

    def _status(self, now_ns: int) -> None:
        if now_ns - self._reported_ns > STATUS_PERIOD_NS:
            self._reported_ns = now_ns
            how = "paused" if self.paused else f"{self._line.speed:g} x"
            self._report(f"at {self._at_ns / NS:.1f} s, {how}, {self.published} messages")
