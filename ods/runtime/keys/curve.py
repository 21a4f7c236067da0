"""CURVE on sockets: who serves, and who connects."""

import zmq

from ods.runtime.keys.key_files import ClientKey, KeyPair

HANDSHAKE_MS = 5000
"""After that who does not finish one is cut."""


def serve_by_keys(socket: "zmq.Socket[bytes]", pair: KeyPair, domain: str) -> None:
    """Let in by CURVE only, whom the context's `Admission` says; `domain`: the name by which it is asked."""
    socket.setsockopt(zmq.CURVE_SERVER, 1)
    socket.setsockopt(zmq.CURVE_PUBLICKEY, pair.public.encode())
    socket.setsockopt(zmq.CURVE_SECRETKEY, pair.secret.encode())
    socket.setsockopt(zmq.ZAP_DOMAIN, domain.encode())
    socket.setsockopt(zmq.ZAP_ENFORCE_DOMAIN, 1)
    socket.setsockopt(zmq.HANDSHAKE_IVL, HANDSHAKE_MS)


def connect_by_key(socket: "zmq.Socket[bytes]", key: ClientKey) -> None:
    """Connect by CURVE, to who has the server's key only."""
    socket.setsockopt(zmq.CURVE_SERVERKEY, key.server.encode())
    socket.setsockopt(zmq.CURVE_PUBLICKEY, key.own.public.encode())
    socket.setsockopt(zmq.CURVE_SECRETKEY, key.own.secret.encode())
    socket.setsockopt(zmq.HANDSHAKE_IVL, HANDSHAKE_MS)
