"""Obstacle lists over the network: tcp with CURVE, by a key that the vehicle allows (`[[bus.listen]]`, `ods keys`).

How old a list is cannot be seen by UTC, unless somebody keeps both computers' right. So it is measured: the first list
of a connection is taken to be new, as nothing waits for a reader who has just come, and by what later ones take longer
than the quickest one they are old. What the way takes at any time is not seen.
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
"""Time without a new list after which the connection is made again, ns: a refused one never tries again by itself, and
the vehicle's clock may have restarted."""
DRIFT = 2e-4
"""By which two computers' clocks differ in speed, at most: so fast the quickest list is forgotten."""
HEARTBEAT_MS, GIVE_UP_MS = 1000, 5000
_KINDS: dict[bytes, type[ObstacleList | Health]] = {b"obstacles": ObstacleList, bus.HEALTH.encode(): Health}


class RemoteError(OdsError):
    """The address or its use is wrong; the text says why in one line."""


class RemoteBus:
    """What `[[bus.listen]]` of a vehicle gives to a client: the lists, and health where it is open, too."""

    def __init__(self, context: "zmq.Context[zmq.Socket[bytes]]", address: str, key: str | Path | None) -> None:
        if key is None:
            raise RemoteError(f"{address}: needs a key: the file that `ods keys make` wrote on the vehicle")
        self._context, self._address, self._key = context, address, read_client_key(Path(key))
        self._decoders = {topic: msgspec.msgpack.Decoder(kind) for topic, kind in _KINDS.items()}
        self._said = ""
        """What the connection's handshake ended with."""
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
        """Least difference of both clocks' times, here and there,"""
        self._counted_ns = 0
        """and when it was counted last, by a clock that goes on while this computer sleeps."""

    def receive(self, timeout_s: float) -> tuple[list[tuple[str, ObstacleList | Health]], list[int]]:
        """Wait at most `timeout_s`; return the newest messages of what came, and no descriptors."""
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
        """Return how old a list is that has just been received."""
        now = time.clock_gettime_ns(time.CLOCK_BOOTTIME)
        took = now - (message.made_ns or message.t_ns)
        if self._quickest_ns is None:
            self._quickest_ns = took
        else:
            self._quickest_ns = min(took, self._quickest_ns + round(DRIFT * (now - self._counted_ns)))
        self._counted_ns = now
        return took - self._quickest_ns

    def worked(self, now_ns: int) -> None:
        """Take note of a list that is new."""
        self._since_ns = now_ns

    def unreachable_reason(self) -> str:
        """Say, after a colon, why nothing is received."""
        while self._monitor.poll(0):
            self._said = _meaning(self._address, recv_monitor_message(self._monitor)) or self._said
        return f": {self._said}" if self._said else f": no answer from {self._address}"

    def close(self) -> None:
        """Give the sockets back."""
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
    """Return what an event of the connection means to who waits for lists; "": nothing."""
    match event:
        case {"event": zmq.EVENT_HANDSHAKE_FAILED_AUTH}:
            return f"{address} refuses this key"
        case {"event": zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL}:
            return f"{address} has another key than `server` in the key file, or is not ods"
        case {"event": zmq.EVENT_HANDSHAKE_SUCCEEDED}:
            return f"connected to {address}, but no new list arrives"
        case _:
            return ""
