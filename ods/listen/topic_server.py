"""One address on which other computers receive topics: a PUB socket with CURVE.

What a reader may cost is bounded: messages that wait for him by the queue, and he himself is cut when he takes nothing
for CUT_S, by the kernel's TCP_USER_TIMEOUT and by ZeroMQ's heartbeats.
"""

import zmq

from ods.runtime import bus
from ods.runtime.keys.curve import serve_by_keys
from ods.runtime.keys.key_files import KeyPair
from ods.runtime.listen import ListenSettings
from ods.runtime.port.backoff import Backoff

CUT_S = 5.0
HEARTBEAT_S = 1.0
LONGEST_COMMAND_BYTES = 1024
"""What a client may send: with CURVE a handshake needs 280, subscriptions less."""
KERNEL_BYTES = 256 * 1024
"""That wait in the kernel, for each reader."""
FIRST_RETRY_S, LONGEST_RETRY_S = 0.05, 1.0


class TopicServer:
    """Binds when it can, tries again where it cannot."""

    def __init__(self, context: "zmq.Context[zmq.Socket[bytes]]", settings: ListenSettings, pair: KeyPair) -> None:
        self.domain = settings.at
        """By which the admission knows it."""
        self.topics = frozenset(settings.topics)
        self.problem = ""
        """Why no connection is possible; "" if one is."""
        self.admitted: set[str] = set()
        """Keys let in since it was bound."""
        self._context, self._settings, self._pair = context, settings, pair
        self._backoff = Backoff(FIRST_RETRY_S, LONGEST_RETRY_S)
        self._due_s = 0.0
        self._socket: zmq.Socket[bytes] | None = None

    def step(self, now_s: float) -> bool:
        """Bind if that is due; return whether it failed."""
        if self._socket is not None or now_s < self._due_s:
            return False
        socket = self._made()
        try:
            socket.bind(self._settings.at)
        except zmq.ZMQError as error:
            socket.close()
            self._due_s = now_s + self._backoff.failed()
            self.problem = f"cannot listen at {self._settings.at}: {zmq.strerror(error.errno or 0).lower()}"
            return True
        self._socket, self.problem = socket, ""
        self._backoff.worked()
        return False

    def _made(self) -> "zmq.Socket[bytes]":
        socket = self._context.socket(zmq.PUB)
        socket.setsockopt(zmq.LINGER, 0)
        socket.setsockopt(zmq.IPV6, int("[" in self._settings.at))
        serve_by_keys(socket, self._pair, self.domain)
        socket.setsockopt(zmq.MAXMSGSIZE, LONGEST_COMMAND_BYTES)
        socket.setsockopt(zmq.RCVHWM, bus.SUBSCRIPTION_QUEUE)
        socket.setsockopt(zmq.SNDHWM, queue_of(self.topics))
        socket.setsockopt(zmq.SNDBUF, KERNEL_BYTES)
        socket.setsockopt(zmq.TCP_MAXRT, round(CUT_S * 1000))
        socket.setsockopt(zmq.HEARTBEAT_IVL, round(HEARTBEAT_S * 1000))
        socket.setsockopt(zmq.HEARTBEAT_TIMEOUT, round(CUT_S * 1000))
        return socket

    def publish(self, topic: bytes, body: bytes) -> bool:
        """Send to all who are connected; return whether the door is open. Who does not keep up misses it."""
        if self._socket is None:
            return False
        self._socket.send(topic, bus.FIRST_PART)
        self._socket.send(body, bus.LAST_PART)
        return True

    def hang_up(self) -> None:
        """Cut all who are connected, as ZeroMQ cannot cut one; those who still may come back by themselves."""
        self.close()
        self.admitted.clear()

    def close(self) -> None:
        """Close the socket, at once."""
        if self._socket is not None:
            self._socket.close(linger=0)
            self._socket = None


def queue_of(topics: frozenset[str]) -> int:
    """Return how many messages may wait for a reader: as many as on board of the topic with the shortest queue."""
    return min(bus.TOPICS[name].queue for name in topics) if topics <= bus.TOPICS.keys() else 4
