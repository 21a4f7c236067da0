"""Obstacle lists over the network: tcp with CURVE, by a key that the vehicle allows (`[[bus.listen]]`, `ods keys`).

The age of a list cannot be derived from UTC unless both computers are synchronized. So it is measured relative to the
fastest list of the connection: the first list is assumed to be new, because nothing is queued for a new reader, and a
later one's age is its additional delay. The constant part of the delay is not observable.
"""

import time
from collections import deque
from pathlib import Path

import msgspec
import zmq
from zmq.utils.monitor import recv_monitor_message

from ods.base import clock
from ods.base.errors import OdsError
from ods.messages import Health, ObstacleList
from ods.runtime import bus
from ods.runtime.keys.curve import connect_by_key
from ods.runtime.keys.key_files import ClientKey, read_client_key

SCHEME = "tcp://"
AGAIN_NS = 3 * clock.NS
"""Time without a new list after which to reconnect, ns: a refused connection never retries by itself, and the vehicle's
clock may have restarted."""
DRIFT = 2e-4
"""Largest relative drift of two computers' clocks: the rate at which the fastest list is forgotten."""
HEARTBEAT_MS, GIVE_UP_MS = 1000, 5000
_KINDS: dict[bytes, type[ObstacleList | Health]] = {b"obstacles": ObstacleList, bus.HEALTH.encode(): Health}


class RemoteError(OdsError):
    """The address cannot be used; the text says why in one line."""


class RemoteBus:
    """Subscribes to a vehicle's `[[bus.listen]]`: obstacle lists and, if served, health."""

    def __init__(self, context: "zmq.Context[zmq.Socket[bytes]]", address: str, key: str | Path | None) -> None:
        if key is None:
            raise RemoteError(f"{address}: needs a key: the file that `ods keys make` wrote on the vehicle")
        self._context, self._address, self._key = context, address, read_client_key(Path(key))
        self._decoders = {topic: msgspec.msgpack.Decoder(kind) for topic, kind in _KINDS.items()}
        self._said = ""
        """Result of the connection's handshake."""
        self._connect()

    def _connect(self) -> None:
        """Raises RemoteError."""
        self._socket = _socket_of(self._context, self._key)
        self._socket.setsockopt(zmq.IPV6, int("[" in self._address))
        self._monitor: zmq.Socket[bytes] = self._socket.get_monitor_socket()
        try:
            self._socket.connect(self._address)
        except zmq.ZMQError as error:
            self.close()
            raise RemoteError(f"{self._address}: {zmq.strerror(error.errno or 0).lower()}") from error
        for topic in _KINDS:
            self._socket.setsockopt(zmq.SUBSCRIBE, topic)
        self._since_ns = clock.monotonic_ns()
        self._quickest_ns: int | None = None
        """Smallest difference between the two computers' clocks, ns."""
        self._counted_ns = 0
        """When `_quickest_ns` was last updated, by a clock that also runs while this computer sleeps."""

    def receive(self, timeout_s: float) -> tuple[list[tuple[str, ObstacleList | Health]], list[int]]:
        """Wait at most `timeout_s`; return the newest messages received, and no file descriptors."""
        if clock.monotonic_ns() - self._since_ns > AGAIN_NS:
            self.close()
            self._connect()
        waiting: deque[tuple[bytes, bytes]] = deque(maxlen=bus.TOPICS["obstacles"].queue)
        if self._socket.poll(max(0, round(timeout_s * 1000))):
            for _ in range(bus.MOST_A_ROUND):
                try:
                    topic, *_, body = self._socket.recv_multipart(zmq.DONTWAIT)
                except (zmq.Again, ValueError):
                    break
                waiting.append((topic, body))
        decoded = [(topic.decode(), self._decoded(topic, body)) for topic, body in waiting if topic in _KINDS]
        return [(topic, message) for topic, message in decoded if message is not None], []

    def _decoded(self, topic: bytes, body: bytes) -> ObstacleList | Health | None:
        try:
            return self._decoders[topic].decode(body)
        except bus.UNDECODABLE:
            return None

    def age_ns(self, message: ObstacleList) -> int:
        """Return the age of a list just received, relative to the fastest one."""
        now = time.clock_gettime_ns(time.CLOCK_BOOTTIME)
        took = now - (message.made_ns or message.t_ns)
        if self._quickest_ns is None:
            self._quickest_ns = took
        else:
            self._quickest_ns = min(took, self._quickest_ns + round(DRIFT * (now - self._counted_ns)))
        self._counted_ns = now
        return took - self._quickest_ns

    def worked(self, now_ns: int) -> None:
        """Record that a new list has arrived."""
        self._since_ns = now_ns

    def unreachable_reason(self) -> str:
        """Return why nothing is received, after a colon."""
        while self._monitor.poll(0):
            self._said = _meaning(self._address, recv_monitor_message(self._monitor)) or self._said
        return f": {self._said}" if self._said else f": no answer from {self._address}"

    def close(self) -> None:
        """Close the sockets."""
        self._socket.disable_monitor()
        self._monitor.close()
        self._socket.close()


def _socket_of(context: "zmq.Context[zmq.Socket[bytes]]", key: ClientKey) -> "zmq.Socket[bytes]":
    socket = context.socket(zmq.SUB)
    socket.setsockopt(zmq.LINGER, 0)
    socket.setsockopt(zmq.RCVHWM, bus.HIGH_WATER_MARK)
    socket.setsockopt(zmq.MAXMSGSIZE, bus.LONGEST_MESSAGE_BYTES)
    socket.setsockopt(zmq.RECONNECT_IVL, 50)
    socket.setsockopt(zmq.RECONNECT_IVL_MAX, 1000)
    socket.setsockopt(zmq.HEARTBEAT_IVL, HEARTBEAT_MS)
    socket.setsockopt(zmq.HEARTBEAT_TIMEOUT, GIVE_UP_MS)
    connect_by_key(socket, key)
    return socket


def _meaning(address: str, event: object) -> str:
    """Return what a connection event means for a user who waits for lists; "": nothing."""
    match event:
        case {"event": zmq.EVENT_HANDSHAKE_FAILED_AUTH}:
            return f"{address} refuses this key"
        case {"event": zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL}:
            return f"{address} has another key than `server` in the key file, or is not ods"
        case {"event": zmq.EVENT_HANDSHAKE_SUCCEEDED}:
            return f"connected to {address}, but no new list arrives"
        case _:
            return ""
