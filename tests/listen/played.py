"""The process's worker beside a tracker that is played, and clients: real ZeroMQ over tcp on loopback."""

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import zmq

from ods.base import clock
from ods.listen.service import ListenWorker
from ods.listen.settings import ListenConfig
from ods.messages import Clearance, ObstacleList
from ods.runtime import bus
from ods.runtime.keys.key_files import ClientKey, read_client_key
from ods.runtime.keys.key_folder import KeyFolder
from ods.runtime.listen import ListenSettings
from ods.runtime.processes import PROCESSES
from ods.runtime.service import Service

PATIENCE_S = 30.0
Socket = zmq.Socket[bytes]


def free_port() -> int:
    with socket.socket() as made:
        made.bind(("127.0.0.1", 0))
        return int(made.getsockname()[1])


class Vehicle:
    """A tracker that publishes, and what passes it on."""

    def __init__(self, folder: Path, *topics: str) -> None:
        self.keys = KeyFolder(folder / "keys")
        self.address = f"tcp://127.0.0.1:{free_port()}"
        self.context: zmq.Context[Socket] = zmq.Context()
        self._tracker = bus.Publisher(self.context, folder, "tracker")
        self.keys.make("planner")
        settings = bus.BusSettings(
            run_dir=folder,
            keys=self.keys.path,
            listen=(ListenSettings(at=self.address, topics=list(topics or ["obstacles"])),),
        )
        self._service = Service(PROCESSES["listen"], folder)
        self.worker = ListenWorker(self._service, ListenConfig(bus=settings))
        self._clients: zmq.Context[Socket] = zmq.Context()
        self._seq = 0
        self.late_ns = 0
        """How old lists are when they are published."""

    @property
    def counters(self) -> dict[str, int]:
        return dict(self._service.counters)

    def step(self) -> None:
        """Publish a list and a clearance, and do what is due."""
        made_ns = clock.monotonic_ns() - self.late_ns
        self._tracker.publish("obstacles", ObstacleList(self._seq, 0, 0, 0, 0, True, [], [], made_ns=made_ns))
        self._tracker.publish("clearance", Clearance(self._seq, 0, 0, 0, True, [], [], []))
        self._seq += 1
        time.sleep(0.005)
        self.worker.tick()

    def flood(self, body: bytes) -> None:
        """Publish a long body as a list."""
        self._tracker._socket.send_multipart([b"obstacles", body])
        self.worker.tick()

    def until(self, wanted: Callable[[], bool]) -> None:
        deadline_s = time.monotonic() + PATIENCE_S
        while not wanted():
            assert time.monotonic() < deadline_s, (self.counters, self.worker.problems())
            self.step()

    def key(self, name: str = "planner") -> ClientKey:
        return read_client_key(self.keys.secret_of(name))

    def client(self, key: ClientKey | None, topic: str = "", queue: int = 1000) -> Socket:
        made = self._clients.socket(zmq.SUB)
        made.setsockopt(zmq.LINGER, 0)
        made.setsockopt(zmq.RECONNECT_IVL, 20)
        made.setsockopt(zmq.RCVHWM, queue)
        if key is not None:
            made.setsockopt(zmq.CURVE_SERVERKEY, key.server.encode())
            made.setsockopt(zmq.CURVE_PUBLICKEY, key.own.public.encode())
            made.setsockopt(zmq.CURVE_SECRETKEY, key.own.secret.encode())
        made.connect(self.address)
        made.setsockopt(zmq.SUBSCRIBE, topic.encode())
        return made

    def close(self) -> None:
        self.worker.stop()
        self._service.close()
        self._tracker.close()
        self.context.destroy(linger=0)
        self._clients.destroy(linger=0)


@contextmanager
def vehicle(folder: Path, *topics: str) -> Iterator[Vehicle]:
    made = Vehicle(folder, *topics)
    try:
        yield made
    finally:
        made.close()


def drained(client: Socket) -> list[tuple[str, int]]:
    """Return topic and number of all that has come."""
    found = []
    while client.poll(0):
        topic, body = client.recv_multipart()
        found.append((topic.decode(), int(msgspec.msgpack.decode(body)["seq"])))
    return found
