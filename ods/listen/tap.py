"""What is published on board, as bytes: the topics of all doors, read empty."""

from collections.abc import Iterator
from pathlib import Path

import zmq

from ods.runtime import bus
from ods.runtime.processes import PROCESSES, SUPERVISOR
from ods.runtime.run_dir import is_safe_to_hear


class Tap:
    """One SUB socket for all."""

    def __init__(self, context: "zmq.Context[zmq.Socket[bytes]]", run_dir: Path, topics: frozenset[str]) -> None:
        self._run_dir, self._safe = run_dir, False
        self._topics = {name.encode() for name in topics}
        self._socket = context.socket(zmq.SUB)
        self._socket.setsockopt(zmq.LINGER, 0)
        self._socket.setsockopt(zmq.RCVHWM, bus.HIGH_WATER_MARK)
        self._socket.setsockopt(zmq.MAXMSGSIZE, bus.LONGEST_MESSAGE_BYTES)
        self._socket.setsockopt(zmq.RECONNECT_IVL, 50)
        self._socket.setsockopt(zmq.RECONNECT_IVL_MAX, 200)
        publishers = {row.publisher for row in bus.TOPICS.values() if row.name in topics}
        if bus.HEALTH in topics:
            publishers |= {SUPERVISOR, *(name for name, row in PROCESSES.items() if row.on_board)}
        for process in sorted(publishers):
            self._socket.connect(bus.endpoint(run_dir, process))
        for topic in self._topics:
            self._socket.setsockopt(zmq.SUBSCRIBE, topic)

    @property
    def fd(self) -> int:
        """Readable when something has come: once, until all of it was received."""
        return int(self._socket.getsockopt(zmq.FD))

    def receive(self) -> Iterator[tuple[bytes, bytes]]:
        """Yield topic and body of what has come. Raises RunDirError where another user could have sent it."""
        for _ in range(bus.MOST_A_ROUND):
            try:
                topic, *_, body = self._socket.recv_multipart(zmq.DONTWAIT)
            except zmq.Again:
                return
            except ValueError:  # one part only: no process on board sends that
                continue
            if topic in self._topics:
                self._safe = self._safe or is_safe_to_hear(self._run_dir)
                yield topic, body

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
