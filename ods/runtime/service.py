"""The life of a process: start, ready, work loop, health, watchdog, stop.

The same for every process, under `ods run` and under systemd: readiness and the watchdog go out by the sd_notify
protocol from the work loop itself, so that a hung loop is seen.
"""

import contextlib
import gc
import logging
import os
import socket
import time
from abc import ABC
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Generic, TypeVar

import msgspec
import psutil
import zmq

from ods.base import clock
from ods.base.computer.memory import TOO_LITTLE, is_too_little
from ods.base.computer.overload import OverloadMonitor
from ods.base.errors import OdsError, missing_kernels_reason
from ods.base.settings import Settings
from ods.messages import Health
from ods.runtime import bus, counters, ending
from ods.runtime.ending import Stop
from ods.runtime.processes import SUPERVISOR, Process
from ods.runtime.run_dir import default_run_dir
from ods.runtime.state_files import exit_reason

log = logging.getLogger(__name__)

SettingsT = TypeVar("SettingsT", bound=Settings)

TICK_S = 0.05
"""Longest the work loop sleeps, so that a stop is quick and time-outs are seen."""


class StartError(OdsError):
    """A process cannot do its work as it is configured; the text says why in one line."""


class Service:
    """Interface of the process for its worker: bus, counters, complaints. One a process."""

    def __init__(self, process: Process, run_dir: Path) -> None:
        self.process = process
        self.run_dir = run_dir
        self.counters: Counter[str] = Counter()
        self.subscriber: bus.Subscriber
        self._complained: set[str] = set()
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context(1)
        self._publisher = bus.Publisher(self._context, run_dir, process.name)
        health_of = (*process.watches, SUPERVISOR) if process.watches else ()
        subscriber = bus.RawSubscriber if process.raw else bus.Subscriber
        self.subscriber = subscriber(self._context, run_dir, process.reads, health_of)
        self._responder = bus.Responder(self._context, run_dir, process.answers) if process.answers else None
        self._flow: Counter[str] = Counter()
        self._newest_ns: dict[str, int] = {}
        self._health_seq = 0
        self._health_ns = clock.monotonic_ns()
        self._usage = psutil.Process()
        self._usage.cpu_percent()
        self._overload = OverloadMonitor()
        self._overload.look(self._health_ns)

    def publish(self, topic: str, message: msgspec.Struct) -> None:
        """Publish on one of this process's topics."""
        self._publisher.publish(topic, message)
        self._flow[topic] += 1

    def requests(self) -> list[tuple[list[bytes], Any]]:
        """Return the requests that have come since: whom to answer, and the request."""
        received = self._responder.receive() if self._responder else []
        for _, request in received:
            self.publish(self.process.answers, request)
        return received

    def answer(self, peer: list[bytes], message: msgspec.Struct) -> None:
        """Answer a request, at once or later."""
        if self._responder:
            self._responder.answer(peer, message)
            self.publish(bus.REQUESTS[self.process.answers].answers, message)

    def stay_reachable(self) -> None:
        """Create lock and sockets again if their files were removed. Raises RunDirError, BusError."""
        gone = self._publisher.restore()
        if self._responder:
            gone |= self._responder.restore()
        if gone:
            log.warning("lock or sockets in the run folder had been removed; created them again")

    def log_once(self, key: str, text: str) -> None:
        """Count `key` every time, log `text` the first time."""
        self.counters[key] += 1
        if key not in self._complained:
            self._complained.add(key)
            log.warning("%s (logged once, then counted as %s)", text, key)

    def overload(self) -> str:
        """Return "the computer is overloaded: ..." if that is why things take long, or "".

        What would otherwise blame a disk, a device or another process asks this first.
        """
        return self._overload.problem(clock.monotonic_ns())

    def receive(self, timeout_s: float) -> tuple[list[tuple[str, Any]], list[int]]:
        """Wait for messages or watched descriptors, and keep the books for the health report."""
        received, fds = self.subscriber.receive(timeout_s)
        now = clock.monotonic_ns()
        for topic, _ in received:
            self._flow[topic] += 1
            self._newest_ns[topic] = now
        return received, fds

    def report_health(self, ready: bool, problems: list[str]) -> None:
        """Publish the health message and start a new period."""
        now = clock.monotonic_ns()
        self._overload.look(now)
        period_s = max(1e-9, (now - self._health_ns) / clock.NS)
        lags: dict[str, int] = {}
        for subscription in self.subscriber.subscriptions:
            if subscription.topic != bus.HEALTH:
                lags[subscription.topic] = subscription.longest
                subscription.longest = 0
        self._publisher.publish(
            bus.HEALTH,
            Health(
                process=self.process.name,
                pid=os.getpid(),
                seq=self._health_seq,
                t_ns=now,
                utc_ns=clock.utc_ns(),
                ready=ready,
                problems=problems,
                counters=self._counts(),
                rates_hz={
                    topic: round(self._flow[topic] / period_s, 3)
                    for topic in (*self.process.reads, *self.process.publishes)
                },
                ages_s={
                    topic: (now - self._newest_ns[topic]) / clock.NS if topic in self._newest_ns else -1.0
                    for topic in self.process.reads
                },
                lags=lags,
                cpu_percent=self._usage.cpu_percent(),
                rss_mb=self._usage.memory_info().rss / 1e6,
            ),
        )
        self._health_seq += 1
        self._health_ns = now
        self._flow.clear()

    def _counts(self) -> dict[str, int]:
        """Return all counters, those of the sockets too."""
        found = Counter(self.counters)
        if self._responder:
            found.update(self._responder.counters)
        for subscription in self.subscriber.subscriptions:
            found.update(subscription.counters)
        counters.refuse_unknown(self.process.name, found)
        return dict(found)

    def close(self) -> None:
        """Give sockets and locks back."""
        self.subscriber.close()
        if self._responder:
            self._responder.close()
        self._publisher.close()
        self._context.term()


class Worker(ABC, Generic[SettingsT]):
    """Provided by a package's service.py: the wiring between its pure code, its device and the bus."""

    def __init__(self, service: Service, settings: SettingsT) -> None:
        self.service = service
        self.settings = settings

    def start(self) -> None:
        """Warm up. Raise StartError when the work can never begin; a device that is away is no reason."""

    def handle(self, topic: str, message: Any) -> None:
        """Handle one message of a topic that this process reads (process table)."""

    def asked(self, peer: list[bytes], request: Any) -> None:
        """Take one request to the socket that the process table says it answers on; `service.answer` it, or later."""

    def readable(self, fd: int) -> None:
        """Read a descriptor given to `service.subscriber.watch_fd`."""

    def tick(self) -> None:
        """Run after every round of the loop, at least every TICK_S: time-outs, re-opening, catching up."""

    def wait_s(self) -> float:
        """Return how long the loop may wait before the next `tick`, TICK_S at most."""
        return TICK_S

    def ready(self) -> bool:
        """Return whether the device has answered and work goes on."""
        return True

    def problems(self) -> list[str]:
        """Return the present problems, a text each."""
        return []

    def stop(self) -> None:
        """Give the device back."""


def notify(text: str) -> bool:
    """Notify the supervisor or systemd, by the sd_notify protocol, if there is one; return whether there is one.

    One that does not listen is not waited for.
    """
    address = os.environ.get("NOTIFY_SOCKET")
    if not address:
        return False
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sock:
        sock.setblocking(False)
        sock.sendto(text.encode(), "\0" + address[1:] if address.startswith("@") else address)
        return True
    return False


def notify_watchdog() -> None:
    """Notify the supervisor or systemd, from within a long round of the work loop, that work continues."""
    notify("WATCHDOG=1")


class Home:
    """Where a process leaves its last words: the default run folder until the configuration has been read."""

    def __init__(self) -> None:
        self.run_dir = default_run_dir()


@contextlib.contextmanager
def report_exit_reason(process: str) -> Iterator[Home]:
    """Report to the supervisor or systemd, and to the tracker, the error that ends the process, if any."""
    home, words = Home(), ""
    try:
        yield home
    except Exception as error:
        text = str(error) if isinstance(error, OdsError) else f"{type(error).__name__}: {error}"
        text = TOO_LITTLE if is_too_little(error) else missing_kernels_reason(error) or text
        words = " ".join(text.split())[: exit_reason.LONGEST_WORDS]
        notify("STOPPING=1\nSTATUS=" + words)
        raise
    finally:
        exit_reason.write(home.run_dir, process, words)


def run_worker(worker_type: type[Worker[Any]], process: Process, run_dir: Path, settings: Any) -> None:
    """Run one process until SIGTERM or SIGINT. Raises OdsError when it cannot work."""
    ending.end_with_supervisor()
    stop = Stop()
    service = Service(process, run_dir)
    try:
        worker = worker_type(service, settings)
        notify(f"STATUS={process.name} is starting")
        worker.start()
        try:
            _loop(service, worker, stop)
        finally:
            notify("STOPPING=1")
            worker.stop()
    finally:
        service.close()


def _loop(service: Service, worker: Worker[Any], stop: Stop) -> None:
    gc.collect()
    gc.freeze()  # what start-up made stays: no later collection has to look through it
    health_due = 0.0
    was_ready = False
    to_tell = ""  # what a supervisor did not receive when it was due
    while not stop.asked:
        received, fds = service.receive(worker.wait_s())
        for topic, message in received:
            worker.handle(topic, message)
        for fd in fds:
            worker.readable(fd)
        for peer, request in service.requests():
            worker.asked(peer, request)
        worker.tick()
        if worker.ready() and not was_ready:
            was_ready = True
            to_tell = "" if notify("READY=1") else "READY=1\n"
            log.info("ready")
        if time.monotonic() >= health_due:
            health_due = time.monotonic() + bus.HEALTH_PERIOD_S
            service.stay_reachable()
            problems = worker.problems()
            if notify(f"{to_tell}WATCHDOG=1\nSTATUS=" + ("; ".join(problems) or "all is well")):
                to_tell = ""
            service.report_health(worker.ready(), problems)
