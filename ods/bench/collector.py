"""The bench's client: receives all messages and keeps the data for the summary and the picture."""

from collections import defaultdict, deque
from functools import partial
from pathlib import Path

import msgspec
import zmq

from ods.base import clock
from ods.bench.spool import Spool
from ods.messages import Detections, Health, ObstacleList, Ping, Truth, VehicleSetPoint, VehicleTruth
from ods.offline.recorded import TruthsByNumber
from ods.offline.run_record import RunRecord
from ods.runtime import bus
from ods.runtime.processes import PROCESSES, SUPERVISOR

SAME_NS = clock.NS // 50
"""So well the time of a beam is known."""


class TruthsByTime:
    """Finds what was true at the pings of a sonar without numbers, that sends one beam at a time."""

    def __init__(self) -> None:
        self._newest: Truth | None = None
        self._waiting: deque[Ping] = deque(maxlen=64)

    def ping(self, ping: Ping) -> None:
        """Take a ping: its truth is that of its newest beam, which may be reported later."""
        self._waiting.append(ping)

    def truth(self, truth: Truth) -> list[Truth]:
        """Take the next truth; return those of pings up to it, with their numbers."""
        before, self._newest = self._newest, truth
        found = []
        while self._waiting and self._waiting[0].t_ns <= truth.t_ns + SAME_NS:
            ping = self._waiting.popleft()
            near = min((each for each in (before, truth) if each), key=lambda each: abs(each.t_ns - ping.t_ns))
            found.append(msgspec.structs.replace(near, ping_number=ping.ping_number))
        return found


class Collector:
    """Subscribes to all topics and all health reports of a run folder."""

    def __init__(self, run_dir: Path, folder: Path | None = None, *, numbered: bool = True) -> None:
        """`folder`: of the results, which has room for what is received.

        numbered: the sonar numbers its pings; else a ping's truth is that of its time.
        """
        self._by_time = None if numbered else TruthsByTime()
        self._truths: Spool[Truth] = Spool(Truth, folder)
        self.record = RunRecord(
            lists=Spool(tuple[int, ObstacleList], folder),
            truths=TruthsByNumber(self._truths),
            health=defaultdict(partial(Spool, Health, folder)),
            way=Spool(VehicleTruth, folder),
            set_points=Spool(VehicleSetPoint, folder),
        )
        self._pings: deque[Ping] = deque(maxlen=8)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        topics = ["obstacles", "truth", "detections", "ping", "vehicle", "set-point"]
        self._subscriber = bus.Subscriber(self._context, run_dir, topics, [*PROCESSES, SUPERVISOR])

    def listen(self, timeout_s: float) -> None:
        """Receive messages for `timeout_s`."""
        received, _ = self._subscriber.receive(timeout_s)
        now = clock.monotonic_ns()
        for _, message in received:
            self._keep(message, now)
        self.record.unread_lists = sum(each.counters["dropped_obstacles"] for each in self._subscriber.subscriptions)

    def _keep(self, message: object, now_ns: int) -> None:
        record = self.record
        match message:
            case ObstacleList():
                record.lists.append((now_ns, message))
            case Truth():
                for truth in [message] if self._by_time is None else self._by_time.truth(message):
                    self._truths.append(truth)
            case Health():
                record.health[message.process].append(message)
            case Ping():
                self._keep_ping(message)
            case VehicleTruth():
                record.way.append(message)
            case VehicleSetPoint():
                record.set_points.append(message)
            case Detections():
                self._keep_image(message)

    def _keep_ping(self, ping: Ping) -> None:
        self._pings.append(ping)
        self.record.received.add(ping.ping_number)
        if self._by_time is not None:
            self._by_time.ping(ping)

    def _keep_image(self, detections: Detections) -> None:
        for ping in self._pings:
            if ping.ping_number == detections.ping_number:
                self.record.image = ping, detections

    def ready(self, process: str) -> bool:
        """Return whether `process` has reported that it is ready."""
        reports = self.record.health[process]
        return bool(reports) and reports[-1].ready

    def down(self) -> str:
        """Return which process ended and why, as `ods run` reported last; '' when none did."""
        newest = [reports[-1] for reports in self.record.health.values() if reports]
        return next((f"{each.process} {'; '.join(each.problems)}" for each in newest if not each.pid), "")

    def busy(self, process: str) -> str:
        """Return what keeps `process` from being ready, as far as it is known."""
        reports = self.record.health[process]
        return "; ".join(reports[-1].problems) if reports else ""

    def close(self) -> None:
        """Give the sockets back."""
        self._subscriber.close()
        self._context.term()
