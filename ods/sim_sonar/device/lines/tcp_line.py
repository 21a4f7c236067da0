"""The far end of a TCP connection: the bare bytes, or those of a 7k center in network frames."""

import contextlib
import socket
import time

from ods.sonar_link.s7k.network_frame import Deframer, frame_record

HOST = "127.0.0.1"
MAX_REQUEST_FRAME_BYTES = 4096
READ_BYTES = 65536


class TcpLine:
    """Listens at a port and serves one client at a time; the next one waits until the first has gone.

    Bytes that nobody reads are lost, and the connection with them.
    """

    needs_subscription = False

    def __init__(self, port: int) -> None:
        """`port` 0: any that is free, see `port`."""
        self.port = port
        self.lost_bytes = 0
        self.connections = 0
        self._server: socket.socket | None = None
        self._client: socket.socket | None = None
        self.plug()

    @property
    def connected(self) -> bool:
        """A client is there, or has not been found gone yet."""
        return self._client is not None

    def plug(self) -> None:
        """Listen."""
        self._server = socket.create_server((HOST, self.port))
        self._server.setblocking(False)
        self.port = self._server.getsockname()[1]

    def unplug(self) -> None:
        """Stop to listen, end the connection."""
        self._hang_up()
        if self._server is not None:
            self._server.close()
            self._server = None

    def write(self, records: list[bytes], patience_s: float) -> bool:
        """Send records; hang up, and count what is lost, when the client takes longer than `patience_s`."""
        deadline_s = time.monotonic() + patience_s
        for record in records:
            if self._client is None:
                return False
            try:
                self._client.settimeout(max(0.001, deadline_s - time.monotonic()))
                self._client.sendall(self._wrapped(record))
            except OSError:
                self.lost_bytes += len(record)
                self._hang_up()
                return False
        return True

    def read(self) -> bytes:
        """Return the bytes of records that a client has sent, b'' when none."""
        if self._client is None:
            self._accept()
        if self._client is None:
            return b""
        try:
            self._client.setblocking(False)
            data = self._client.recv(READ_BYTES)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._hang_up()
            return b""
        return self._unwrapped(data)

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            if self._server is not None:
                self._client, _ = self._server.accept()
                self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self.connections += 1
                self._begin()

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None

    def _begin(self) -> None:
        """A client has come."""

    def _wrapped(self, record: bytes) -> bytes:
        return record

    def _unwrapped(self, data: bytes) -> bytes:
        return data


class FramedTcpLine(TcpLine):
    """The same with network frames around the records of both sides."""

    needs_subscription = True

    def __init__(self, port: int) -> None:
        """`port` 0: any that is free, see `port`."""
        self._deframer = Deframer(MAX_REQUEST_FRAME_BYTES)
        self._transmissions = 0
        super().__init__(port)

    def _begin(self) -> None:
        self._deframer = Deframer(MAX_REQUEST_FRAME_BYTES)

    def _wrapped(self, record: bytes) -> bytes:
        self._transmissions += 1
        return frame_record(record, self._transmissions)

    def _unwrapped(self, data: bytes) -> bytes:
        return self._deframer.feed(data)
