"""A vehicle's own bus, looked at: the newest of everything, who is silent, what happened. Nothing is ever sent."""

import re
import threading
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import zmq

from ods.base import clock
from ods.base.arrays import Floats
from ods.base.clock import MS, NS
from ods.messages import Detections, Health, ObstacleList, Ping, Pose, Truth
from ods.runtime import bus
from ods.runtime.caution import cautions
from ods.runtime.counters import trouble_names
from ods.runtime.ping_pace import PingPace
from ods.runtime.processes import SUPERVISOR, may_be_on_board
from ods.runtime.run_dir import RunDirError
from ods.workbench.engine.background.listeners import Listeners

TOPICS = ("ping", "pose", "detections", "obstacles", "truth")
WORDS = {"ping": "pings", "pose": "poses", "detections": "detections", "obstacles": "obstacle lists", "truth": "truth"}
PACED = "ping", "detections"
"""How often these come is the sonar's business."""
WAIT_S = 0.1
LOOK_S = 0.25
"""Between two looks at who is silent."""
LOG_LINES = 300
RATE_S = 3.0
"""Time over which a rate is measured, s."""
PATH_S = 0.5
"""Time between two stored positions of the path."""
PATH_PLACES = 2000
"""Largest number of stored positions."""
LATENCIES = 600
"""Lists whose latency is kept: 90 s."""


class Line(NamedTuple):
    """One line of the log."""

    utc_ns: int
    text: str
    bad: bool


class Verdict(NamedTuple):
    """May a planner rely on what it receives at this moment?"""

    valid: bool
    reasons: tuple[str, ...]
    """Why not, in plain words."""
    caution: str
    """What of the sector a valid list cannot vouch for; empty: nothing."""


class Latency(NamedTuple):
    """Of the newest lists, (n,) each."""

    at_s: Floats
    """When they came; the newest is at 0."""
    whole_ms: Floats
    """From the transmission of the ping until the list was received here."""
    own_ms: Floats
    """From the ping's last byte until then: what the computer takes."""


@dataclass
class _Latest:
    """What came of one topic."""

    newest: Any = None
    at_ns: int = 0
    arrivals: "deque[int]" = field(default_factory=lambda: deque(maxlen=1000))
    pace: PingPace = field(default_factory=PingPace)


class Live:
    """Listens in a thread of its own until it is closed."""

    def __init__(self, run_dir: Path) -> None:
        """run_dir: where the processes of the vehicle meet."""
        self.run_dir = run_dir
        self.log: deque[Line] = deque(maxlen=LOG_LINES)
        """The newest last."""
        self.health: dict[str, Health] = {}
        """By process."""
        self.path: deque[tuple[float, float]] = deque(maxlen=PATH_PLACES)
        """Where the vehicle was: north and east, m."""
        self.lost: Counter[str] = Counter()
        """Messages that came faster than they were read, or made no sense."""
        self._latest = {topic: _Latest() for topic in TOPICS}
        self._health_ns: dict[str, int] = {}
        self._path_ns = 0
        self._latency: deque[tuple[int, float, float]] = deque(maxlen=LATENCIES)
        self._listeners: Listeners[[str]] = Listeners()
        self._said: dict[str, str] = {}
        self._began_ns = clock.monotonic_ns()
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._run, name="live", daemon=True)
        self._thread.start()

    def listen(self, changed: Callable[[str], None]) -> Callable[[], None]:
        """Call `changed`, in the thread, with each topic of which something came, and "" every LOOK_S.

        What is returned ends that.
        """
        return self._listeners.add(changed)

    def close(self) -> None:
        """Listen no more."""
        self._ends.set()
        self._thread.join(timeout=5.0)

    # -- what is known --

    @property
    def ping(self) -> Ping | None:
        """The newest."""
        newest: Ping | None = self._latest["ping"].newest
        return newest

    @property
    def detections(self) -> Detections | None:
        """The newest."""
        newest: Detections | None = self._latest["detections"].newest
        return newest

    @property
    def pose(self) -> Pose | None:
        """The newest."""
        newest: Pose | None = self._latest["pose"].newest
        return newest

    @property
    def obstacles(self) -> ObstacleList | None:
        """The newest."""
        newest: ObstacleList | None = self._latest["obstacles"].newest
        return newest

    @property
    def truth(self) -> Truth | None:
        """The newest; of a simulation only."""
        newest: Truth | None = self._latest["truth"].newest
        return newest

    def age_s(self, topic: str, now_ns: int) -> float | None:
        """Return for how long nothing came on a topic; None: nothing ever came."""
        latest = self._latest[topic]
        return None if latest.newest is None else (now_ns - latest.at_ns) / NS

    def rate_hz(self, topic: str, now_ns: int) -> float:
        """Return how many messages a second come on a topic."""
        since_ns = max(now_ns - round(RATE_S * NS), self._began_ns)
        count = sum(1 for t in list(self._latest[topic].arrivals) if t > since_ns)
        return count / max(1e-3, (now_ns - since_ns) / NS)

    def silences(self, now_ns: int) -> list[str]:
        """Return which topics are silent and for how long, in words: "no pings for 3.2 s"."""
        said = []
        for topic in ("ping", "pose", "detections", "obstacles"):
            age_s = self.age_s(topic, now_ns)
            if age_s is None:
                said.append(f"no {WORDS[topic]} yet{bus.unreachable_reason(self.run_dir, bus.TOPICS[topic].publisher)}")
            elif age_s > self._patience_s(topic):
                said.append(f"no {WORDS[topic]} for {age_s:.1f} s")
        return said

    def _patience_s(self, topic: str) -> float:
        return self._latest[topic].pace.patience_s if topic in PACED else bus.TOPICS[topic].stale_s

    def verdict(self, now_ns: int) -> Verdict:
        """Return what a planner has to make of the newest list: silence of the tracker is a reason, too."""
        latest, age_s = self.obstacles, self.age_s("obstacles", now_ns)
        if latest is None or age_s is None:
            return Verdict(False, (f"no obstacle list yet{bus.unreachable_reason(self.run_dir, 'tracker')}",), "")
        if age_s > bus.TOPICS["obstacles"].stale_s:
            why = bus.unreachable_reason(self.run_dir, "tracker")
            return Verdict(False, (f"no obstacle list for {age_s:.1f} s{why}",), "")
        return Verdict(latest.valid, tuple(latest.reasons), "; ".join(cautions(latest)))

    def health_age_s(self, process: str, now_ns: int) -> float | None:
        """Return how old the newest word of a process about itself is; None: there was none."""
        return (now_ns - self._health_ns[process]) / NS if process in self._health_ns else None

    def latency(self, now_ns: int) -> Latency:
        """Return the latencies of the newest lists."""
        rows = np.array(list(self._latency), np.float64).reshape(-1, 3)
        return Latency((rows[:, 0] - now_ns) / NS, rows[:, 1], rows[:, 2])

    # -- the thread --

    def _run(self) -> None:
        names = [*(process.name for process in may_be_on_board()), "sim", SUPERVISOR]
        looked_ns = 0
        with zmq.Context() as context, bus.Subscriber(context, self.run_dir, TOPICS, names) as subscriber:
            while not self._ends.is_set():
                received = self._received(subscriber)
                now_ns = clock.monotonic_ns()
                for topic, message in received:
                    self._take(topic, message, now_ns)
                for topic in dict.fromkeys(topic for topic, _ in received if topic != bus.HEALTH):
                    self._listeners.notify(topic)
                if now_ns - looked_ns >= LOOK_S * NS:
                    looked_ns = now_ns
                    for subscription in subscriber.subscriptions:
                        self.lost += subscription.counters
                        subscription.counters.clear()
                    self._look(now_ns)
                    self._listeners.notify("")

    def _received(self, subscriber: bus.Subscriber) -> list[tuple[str, Any]]:
        try:
            return subscriber.receive(WAIT_S)[0]
        except RunDirError as error:
            self._say_once("run_dir", str(error), bad=True)
            return []

    def _take(self, topic: str, message: Any, now_ns: int) -> None:
        if isinstance(message, Health):
            self._note_counters(message)
            self.health[message.process] = message
            self._health_ns[message.process] = now_ns
            return
        latest = self._latest[topic]
        latest.newest, latest.at_ns = message, now_ns
        latest.arrivals.append(now_ns)
        latest.pace.ping(now_ns)
        if isinstance(message, Pose) and now_ns - self._path_ns >= PATH_S * NS:
            self._path_ns = now_ns
            self.path.append(message.position_ned[:2])
        if isinstance(message, ObstacleList) and message.t_rx_ns:
            self._latency.append((now_ns, (now_ns - message.t_ns) / MS, (now_ns - message.t_rx_ns) / MS))

    def _note_counters(self, report: Health) -> None:
        """Log what a process lost since its last word."""
        before = self.health.get(report.process)
        if before is None or before.pid != report.pid:
            return
        troubles = trouble_names(report.process)
        for name, count in report.counters.items():
            more = count - before.counters.get(name, 0)
            if more > 0 and name in troubles:
                self._say(f"{report.process}: {name} {more} more, {count} in all", bad=True)

    def _look(self, now_ns: int) -> None:
        """Log what changed since the last look."""
        verdict = self.verdict(now_ns)
        line = "the list is valid" if verdict.valid else "the list is NOT VALID: " + "; ".join(verdict.reasons)
        self._say_once("list", line, not verdict.valid)
        silences = self.silences(now_ns)
        for topic in ("ping", "pose", "detections"):
            why = next((text for text in silences if text.startswith(f"no {WORDS[topic]}")), "")
            self._say_once(topic, why or f"{WORDS[topic]} come", bool(why))
        for process, report in list(self.health.items()):
            state, bad = state_of(report, self.health_age_s(process, now_ns))
            self._say_once(process, f"{process}: {state}", bad)

    def _say_once(self, of: str, text: str, bad: bool) -> None:
        """Log a text unless it was said last; the same with other numbers is the same."""
        same = re.sub(r"[0-9.]+", "#", text)
        if self._said.get(of) != same:
            self._said[of] = same
            self._say(text, bad)

    def _say(self, text: str, bad: bool) -> None:
        self.log.append(Line(clock.utc_ns(), text, bad))


def state_of(report: Health | None, age_s: float | None) -> tuple[str, bool]:
    """Return how a process is, in words, and whether that is bad; age_s: of the report."""
    if report is None or age_s is None:
        return "not heard of", True
    if age_s > bus.HEALTH_STALE_S:
        return f"silent for {age_s:.0f} s", True
    if report.problems:
        return "; ".join(report.problems), True
    return ("ready", False) if report.ready else ("starting", True)
