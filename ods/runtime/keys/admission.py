"""Admission of clients: ZeroMQ's authentication protocol (ZAP, RFC 27), answered by the list of keys.

There is no other way in: doors refuse to work without it (ZAP_ENFORCE_DOMAIN), and every mechanism but CURVE.
"""

from collections.abc import Mapping
from typing import NamedTuple

import zmq
from zmq.utils import z85

ADDRESS = "inproc://zeromq.zap.01"
VERSION = b"1.0"


class Asked(NamedTuple):
    """One who asked to be let in, and what he was answered."""

    domain: str
    """Of the door."""
    address: str
    key: str
    """Z85."""
    name: str
    """By which the list knows the key; "": it does not, and he was refused."""


class Admission:
    """Answers for all doors of a context; made before them. A message's `User-Id` is then the sender's public key."""

    def __init__(self, context: "zmq.Context[zmq.Socket[bytes]]") -> None:
        self.socket = context.socket(zmq.ROUTER)
        self.socket.setsockopt(zmq.LINGER, 0)
        self.socket.bind(ADDRESS)

    def answer(self, names: Mapping[str, str]) -> list[Asked]:
        """Answer all who wait; `names`: of those who may, by public key."""
        asked: list[Asked] = []
        while True:
            try:
                parts = self.socket.recv_multipart(zmq.DONTWAIT)
            except zmq.Again:
                return asked
            peer, empty, _, request, domain, address, _, mechanism, *credentials = parts
            key = z85.encode(credentials[0]).decode() if mechanism == b"CURVE" and credentials else ""
            name = names.get(key, "")
            status = [b"200", b"OK", key.encode()] if name else [b"400", b"no such key", b""]
            self.socket.send_multipart([peer, empty, VERSION, request, *status, b""])
            asked.append(Asked(domain.decode(), address.decode(), key, name))

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()
