"""The one topic table, the one request table, and their ZeroMQ sockets.

Each process binds one PUB socket, ipc://<run_dir>/<process>.sock, and publishes all its topics there as two parts:
topic name, msgpack map. A process that takes requests binds a ROUTER socket besides. Subscribers open one SUB socket a
topic, read it empty and keep the newest messages, because a full ZeroMQ queue keeps the oldest and CONFLATE breaks
multipart messages.
"""

import contextlib
import logging
import math
import os
import socket
import time
from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import msgspec
import zmq

from ods import messages
from ods.base.choices import none_of
from ods.base.errors import OdsError
from ods.base.settings import Settings
from ods.runtime.keys.curve import serve_by_keys
from ods.runtime.keys.key_files import KeyPair
from ods.runtime.listen import ListenSettings
from ods.runtime.raw_bytes import RawBytes
from ods.runtime.run_dir import FOR_GROUP, Lock, default_run_dir, identity, is_safe_to_hear, sockets_made

log = logging.getLogger(__name__)

LONGEST_MESSAGE_BYTES = 64 * 1024 * 1024
LONGEST_REQUEST_BYTES = 64 * 1024
READABLE_REQUEST_BYTES = 4 * 1024 * 1024
"""Requests up to this size are answered with the reason; on longer ones ZeroMQ hangs up without a word."""
REQUEST_QUEUE = 16
"""Requests that wait of each peer: what bounds the memory that long ones take."""
UNDECODABLE = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
"""What decoding may raise: neither a text that is not UTF-8 nor too deep a nesting is a DecodeError."""
LONGEST_SUBSCRIPTION_BYTES = 64
SUBSCRIPTION_QUEUE = 16
"""The name of a topic, and how many wait of each peer. The publisher itself takes them in, while it publishes: 20 000
of 200 bytes held it up for 0.4 s, and again when that peer left."""
HIGH_WATER_MARK = 256
MOST_A_ROUND = 4096
"""Messages of a topic read at a time: 10 ms."""
GATHER_S = 0.02
"""What comes meanwhile is taken together where all topics are: pose by pose, recording took half as much time again."""
FIRST_PART, LAST_PART = int(zmq.SNDMORE | zmq.DONTWAIT), int(zmq.DONTWAIT)
_DONTWAIT, _MORE = int(zmq.DONTWAIT), int(zmq.RCVMORE)
"""Plain integers: the sum of two flags is dear, and enumerations are."""


@dataclass(frozen=True)
class Topic:
    """One row of the topic table."""

    name: str
    message: type[msgspec.Struct]
    publisher: str
    """The process that publishes it."""
    rate_hz: float
    """Expected rate, 0: now and then; a topic is stale when nothing came for `stale_s`."""
    queue: int
    """Messages a subscriber keeps when it lags: the newest."""
    stale_s: float = math.inf
    """Silence after which a consumer calls the topic dead."""


TOPICS: dict[str, Topic] = {
    topic.name: topic
    for topic in (
        Topic("ping", messages.Ping, "sonar", 6.7, queue=8, stale_s=1.0),
        Topic("pose", messages.Pose, "nav", 100.0, queue=200, stale_s=0.5),
        Topic("detections", messages.Detections, "pipeline", 6.7, queue=16, stale_s=1.0),
        Topic("obstacles", messages.ObstacleList, "tracker", 6.7, queue=16, stale_s=1.0),
        Topic("clearance", messages.Clearance, "tracker", 6.7, queue=16, stale_s=1.0),
        Topic("truth", messages.Truth, "sim", 6.7, queue=64, stale_s=1.0),
        Topic("vehicle", messages.VehicleTruth, "sim", 20.0, queue=64, stale_s=1.0),
        Topic("set-point", messages.VehicleSetPoint, "planner", 5.0, queue=16, stale_s=1.0),
        Topic("raw", RawBytes, "sonar", 0.0, queue=HIGH_WATER_MARK),
        Topic("sonar-requests", messages.SonarRequest, "sonar", 0.0, queue=16),
        Topic("sonar-answers", messages.SonarAnswer, "sonar", 0.0, queue=16),
        Topic("veto-orders", messages.VetoOrder, "tracker", 0.0, queue=16),
    )
}
"""Every topic but health, which each process publishes under the name `health` on its own socket."""


@dataclass(frozen=True)
class Request:
    """One row of the request table: a socket that answers."""

    name: str
    """Of the socket: ipc://<run_dir>/<name>.sock."""
    request: type[msgspec.Struct]
    answer: type[msgspec.Struct]
    process: str
    """The process that answers."""
    answers: str = ""
    """Topic on which it publishes its answers; the requests are published on that of the socket's name. '': neither."""
    keyed: bool = False
    """It takes requests by the keys of operators only, where there are any."""


REQUESTS: dict[str, Request] = {
    row.name: row
    for row in (
        Request("sonar-requests", messages.SonarRequest, messages.SonarAnswer, "sonar", "sonar-answers"),
        Request("veto-requests", messages.VetoRequest, messages.VetoAnswer, "tracker", keyed=True),
        Request("replay-requests", messages.ReplayRequest, messages.ReplayAnswer, "replay"),
    )
}

HEALTH = "health"
HEALTH_PERIOD_S = 0.5
HEALTH_STALE_S = 2.0


class BusSettings(Settings, frozen=True):
    """The bus between processes."""

    run_dir: Path = msgspec.field(default_factory=default_run_dir)
    """Sockets and locks; under 80 characters. Left out: /run/ods for root and where it exists, else
    $XDG_RUNTIME_DIR/ods, else ~/.local/state/ods/run."""
    keys: Path | None = None
    """Folder of other computers' keys (`ods keys`), owned by the processes' user."""
    listen: tuple[ListenSettings, ...] = ()
    """For other computers, encrypted."""

    def __post_init__(self) -> None:
        if len(str(self.run_dir)) > 80:
            raise ValueError(f"run_dir: {self.run_dir} is longer than 80 characters, too long for a socket path")
        for number, each in enumerate(self.listen):
            if each.at in [other.at for other in self.listen[:number]]:
                raise ValueError(
                    f"listen[{number}].at: {each.at} has its [[bus.listen]] already: list all topics there"
                )
            for name in each.topics:
                if name not in (*TOPICS, HEALTH):
                    raise ValueError(f"listen[{number}].topics: {none_of(name, (*TOPICS, HEALTH))}")
        if self.listen and self.keys is None:
            raise ValueError('keys: missing: the folder in which `ods keys make` puts the keys, such as "keys"')


class BusError(OdsError):
    """The bus cannot be used; the text says why in one line."""


def endpoint(run_dir: Path, process: str) -> str:
    """Return the ZeroMQ address that `process` binds."""
    return f"ipc://{run_dir / process}.sock"


def unreachable_reason(run_dir: Path, process: str) -> str:
    """Return, after a colon, why `process` cannot be received; "" when it is only silent."""
    file = run_dir / f"{process}.sock"
    try:
        file.stat()
        usable, asked = os.access(file, os.W_OK), file
    except PermissionError:
        usable, asked = False, run_dir
    except OSError:
        return f": {run_dir} has no socket of the {process}: does it run, and with this run_dir?"
    if not usable:
        return f": no permission to open {file}: {_who_may(asked)}"
    return "" if _has_listener(file) else f": no {process} runs with run_dir {run_dir}: it has ended or was killed"


def _has_listener(file: Path) -> bool:
    """Return whether a process holds a socket, which outlives it; it is not disturbed."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        probe.setblocking(False)  # the queue of one that hangs may be full
        try:
            probe.connect(str(file))
        except ConnectionRefusedError:
            return False
        except OSError:
            return True
    return True


def _who_may(place: Path) -> str:
    """Return the users who may use a file, as text."""
    try:
        return f"join the group {place.group()} (and log in again), or run as {place.owner()}"
    except (OSError, KeyError):  # out of reach, or of a group or user without a name
        return "join the group of its owner, or run as its owner"


class Publisher:
    """The PUB socket of one process. A lock file keeps a second process from stealing the path silently."""

    def __init__(self, context: "zmq.Context[zmq.Socket[bytes]]", run_dir: Path, process: str) -> None:
        self._lock = Lock(run_dir, process)
        self._lock.write(b"")  # whatever ended a former process
        self._encoder = msgspec.msgpack.Encoder()
        self._socket = context.socket(zmq.PUB)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.SNDHWM, HIGH_WATER_MARK)
        self._socket.setsockopt(zmq.MAXMSGSIZE, LONGEST_SUBSCRIPTION_BYTES)
        self._socket.setsockopt(zmq.RCVHWM, SUBSCRIPTION_QUEUE)
        self._binding = _Binding(self._socket, run_dir, process)

    def publish(self, topic: str, message: msgspec.Struct) -> None:
        """Send `message`; never blocks."""
        self._socket.send(topic.encode(), FIRST_PART)
        self._socket.send(self._encoder.encode(message), LAST_PART)

    def restore(self) -> bool:
        """Create lock or socket again if removed; return whether one was. Raises RunDirError, BusError."""
        lock_gone, socket_gone = self._lock.restore(), self._binding.restore()
        return lock_gone or socket_gone

    def close(self) -> None:
        """Close the socket and give the lock back."""
        self._socket.close()
        self._lock.close()


class _Binding:
    """The address of a bound socket. Others connect by its file: without it the socket gets no new connections."""

    def __init__(self, socket: "zmq.Socket[bytes]", run_dir: Path, name: str) -> None:
        self._socket, self._address = socket, endpoint(run_dir, name)
        self._file = Path(self._address.removeprefix("ipc://"))
        self._bind()

    def _bind(self) -> None:
        try:
            with sockets_made(FOR_GROUP):
                self._socket.bind(self._address)
        except zmq.ZMQError as error:
            raise BusError(f"bus.run_dir: cannot bind {self._address}: {error}") from error
        self._identity = identity(self._file)

    def restore(self) -> bool:
        """Bind again if the file was removed or replaced; return whether it was. Connections stay."""
        if identity(self._file) == self._identity:
            return False
        self._bind()  # without unbinding: that would remove the new file a moment later
        return True


class Responder:
    """The ROUTER socket behind one row of REQUESTS: every request gets one answer, at once or later; never blocks.

    Bad requests are answered with the reason and counted as bad_<name>.
    """

    def __init__(
        self, context: "zmq.Context[zmq.Socket[bytes]]", run_dir: Path, name: str, pair: KeyPair | None = None
    ) -> None:
        """Bind. The process's Publisher holds the lock that keeps a second one from stealing the path.

        With a `pair` only those come in whom the context's `Admission` lets in by their keys.
        """
        self.counters: Counter[str] = Counter()
        self._row = REQUESTS[name]
        self._decoder: msgspec.msgpack.Decoder[Any] = msgspec.msgpack.Decoder(self._row.request)
        self._encoder = msgspec.msgpack.Encoder()
        self._socket = context.socket(zmq.ROUTER)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.RCVHWM, REQUEST_QUEUE)
        self._socket.setsockopt(zmq.SNDHWM, HIGH_WATER_MARK)
        self._socket.setsockopt(zmq.MAXMSGSIZE, READABLE_REQUEST_BYTES)
        self._keyed = pair is not None
        if pair is not None:
            serve_by_keys(self._socket, pair, name)
        self._binding = _Binding(self._socket, run_dir, name)

    def receive(self) -> list[tuple[list[bytes], Any]]:
        """Return what has come since, at most HIGH_WATER_MARK: whom to answer, and the request."""
        return [(peer, request) for peer, request, _ in self.receive_keyed()]

    def receive_keyed(self) -> list[tuple[list[bytes], Any, str]]:
        """Return the same, each with the public key that its sender came in by; "": without one."""
        received = []
        for _ in range(HIGH_WATER_MARK):
            try:
                frames = self._socket.recv_multipart(zmq.DONTWAIT, copy=False)
            except zmq.Again:
                break
            *peer, body = (frame.bytes for frame in frames)
            key = str(frames[-1].get("User-Id")) if self._keyed else ""
            try:
                received.append((peer, self._decode(body), key))
            except UNDECODABLE as error:
                self.counters[f"bad_{self._row.name}"] += 1
                self.answer(peer, self._row.answer(ok=False, reason=f"bad request: {error}"))
        return received

    def _decode(self, body: bytes) -> Any:
        """Raises one of UNDECODABLE."""
        if len(body) > LONGEST_REQUEST_BYTES:
            raise msgspec.DecodeError(f"{len(body)} bytes are more than {LONGEST_REQUEST_BYTES}")
        return self._decoder.decode(body)

    def answer(self, peer: list[bytes], message: msgspec.Struct) -> None:
        """Answer one request; an answer that is not taken is dropped."""
        with contextlib.suppress(zmq.ZMQError):
            self._socket.send_multipart([*peer, self._encoder.encode(message)], flags=zmq.DONTWAIT)

    def restore(self) -> bool:
        """Create the socket again if its file was removed; return whether it was. Raises BusError."""
        return self._binding.restore()

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class Subscription:
    """One SUB socket: the newest messages of one topic, decoded and checked."""

    def __init__(
        self,
        context: "zmq.Context[zmq.Socket[bytes]]",
        run_dir: Path,
        topic: str,
        publisher: str,
        message: type[msgspec.Struct],
        queue: int,
    ) -> None:
        self.topic = topic
        self.counters: Counter[str] = Counter()
        self.longest = 0
        self._decoder: msgspec.msgpack.Decoder[Any] = msgspec.msgpack.Decoder(message)
        self._waiting: deque[bytes] = deque(maxlen=queue)
        self._complained = False
        self.socket = context.socket(zmq.SUB)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.setsockopt(zmq.RCVHWM, HIGH_WATER_MARK)
        self.socket.setsockopt(zmq.MAXMSGSIZE, LONGEST_MESSAGE_BYTES)
        self.socket.setsockopt(zmq.RECONNECT_IVL, 50)
        self.socket.setsockopt(zmq.RECONNECT_IVL_MAX, 200)
        self.socket.connect(endpoint(run_dir, publisher))
        self.socket.setsockopt(zmq.SUBSCRIBE, topic.encode())

    def receive(self) -> list[Any]:
        """Read the socket empty; return the newest messages in order, at most the topic's queue length.

        A flood that comes faster than it is read leaves the rest for the next round.
        """
        arrived = 0
        while arrived < MOST_A_ROUND:
            try:
                parts = self.socket.recv_multipart(zmq.DONTWAIT)
            except zmq.Again:
                break
            arrived += 1
            if len(self._waiting) == self._waiting.maxlen:
                self.counters[f"dropped_{self.topic}"] += 1
            self._waiting.append(parts[-1])
        self.longest = max(self.longest, arrived)
        good = [message for message in map(self._decode, self._waiting) if message is not None]
        self._waiting.clear()
        return good

    def _decode(self, body: bytes) -> Any:
        try:
            return self._decoder.decode(body)
        except UNDECODABLE as error:
            self.counters[f"bad_{self.topic}"] += 1
            if not self._complained:
                log.warning("dropped a malformed %s message: %s", self.topic, error)
                self._complained = True
            return None

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()


class Subscriber:
    """Subscriptions to several topics and to the health of several processes, polled together."""

    def __init__(
        self,
        context: "zmq.Context[zmq.Socket[bytes]]",
        run_dir: Path,
        topics: Iterable[str],
        health_of: Iterable[str] = (),
        queue: int | None = None,
    ) -> None:
        """Connect to everything named; `queue`: messages to keep of each topic, instead of the topic's own number."""
        own = [(row.name, row.publisher, row.message, queue or row.queue) for row in map(TOPICS.__getitem__, topics)]
        health = [(HEALTH, process, messages.Health, queue or 4) for process in health_of]
        wanted: list[tuple[str, str, type[msgspec.Struct], int]] = [*own, *health]
        self.subscriptions = [
            Subscription(context, run_dir, topic, publisher, message, length)
            for topic, publisher, message, length in wanted
        ]
        self._run_dir, self._safe = run_dir, False
        self._poller = zmq.Poller()
        for subscription in self.subscriptions:
            self._poller.register(subscription.socket, zmq.POLLIN)

    def __enter__(self) -> "Subscriber":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def unsubscribe(self, topic: str) -> None:
        """Receive no more of a topic that the configuration does not want."""
        for subscription in [each for each in self.subscriptions if each.topic == topic]:
            self.subscriptions.remove(subscription)
            self._poller.unregister(subscription.socket)
            subscription.close()

    def watch_fd(self, fd: int) -> None:
        """Let `receive` wake up when `fd` becomes readable."""
        self._poller.register(fd, zmq.POLLIN)

    def unwatch_fd(self, fd: int) -> None:
        """Undo `watch_fd`."""
        self._poller.unregister(fd)

    def receive(self, timeout_s: float) -> tuple[list[tuple[str, Any]], list[int]]:
        """Wait at most `timeout_s`; return (topic, message) pairs and the watched descriptors that are readable.

        Raises RunDirError, and drops what came, where another user could have sent it.
        """
        if not self._poller.sockets:  # ZeroMQ would not wait at all
            time.sleep(timeout_s)
            return [], []
        ready = dict(self._poller.poll(max(0, round(timeout_s * 1000))))
        received: list[tuple[str, Any]] = []
        for subscription in self.subscriptions:
            if ready.pop(subscription.socket, None):
                received += [(subscription.topic, message) for message in subscription.receive()]
        self._safe = self._safe or (bool(received) and is_safe_to_hear(self._run_dir))
        return received, [fd for fd in ready if isinstance(fd, int)]

    def close(self) -> None:
        """Close all sockets."""
        for subscription in self.subscriptions:
            subscription.close()


class RawSubscriber(Subscriber):
    """Everything that several processes publish, as bytes, in the order of arrival: one SUB socket for all."""

    def __init__(
        self, context: "zmq.Context[zmq.Socket[bytes]]", run_dir: Path, topics: Iterable[str], health_of: Iterable[str]
    ) -> None:
        """Connect to the publishers of all topics, and to those of health."""
        super().__init__(context, run_dir, ())
        rows = [TOPICS[name] for name in topics]
        self._socket = context.socket(zmq.SUB)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.RCVHWM, 4 * HIGH_WATER_MARK)
        self._socket.setsockopt(zmq.MAXMSGSIZE, LONGEST_MESSAGE_BYTES)
        self._socket.setsockopt(zmq.RECONNECT_IVL, 50)
        self._socket.setsockopt(zmq.RECONNECT_IVL_MAX, 200)
        for process in dict.fromkeys([*(row.publisher for row in rows), *health_of]):
            self._socket.connect(endpoint(run_dir, process))
        self._poller.register(self._socket, zmq.POLLIN)
        for topic in (*(row.name for row in rows), HEALTH):
            self._socket.setsockopt(zmq.SUBSCRIBE, topic.encode())

    def receive(self, timeout_s: float) -> tuple[list[tuple[str, Any]], list[int]]:
        """Wait at most `timeout_s`; return (topic, bytes) pairs of the next GATHER_S; no descriptors are watched."""
        received: list[tuple[str, Any]] = []
        socket = self._socket
        if not self._poller.poll(max(0, round(timeout_s * 1000))):
            return received, []
        time.sleep(GATHER_S)
        while len(received) < MOST_A_ROUND:
            try:
                topic = socket.recv(_DONTWAIT)
            except zmq.Again:
                break
            body = socket.recv(_DONTWAIT)
            while socket.getsockopt(_MORE):
                body = socket.recv(_DONTWAIT)
            received.append((topic.decode(errors="replace"), body))
        return received, []

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
