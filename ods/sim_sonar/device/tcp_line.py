"""The far end of a TCP connection: the simulated sonar as a 7k center with network frames."""

import contextlib
import socket
import time

from ods.sonar_link.s7k.network_frame import Deframer, frame_record

HOST = "127.0.0.1"
MAX_REQUEST_BYTES = 4096
READ_BYTES = 65536


class TcpLine:
    """Listens at a port and serves one client at a time; the next one waits until the first has gone.

    Bytes that nobody reads are lost, and the connection with them.
    """

    needs_subscription = True

    def __init__(self, port: int) -> None:
        """`port` 0: any that is free, see `port`."""
        self.port = port
        self.lost_bytes = 0
        self.connections = 0
        self._server: socket.socket | None = None
        self._client: socket.socket | None = None
        self._deframer = Deframer(MAX_REQUEST_BYTES)
        self._transmissions = 0
        self.plug()

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
        """Send framed records; hang up, and count what is lost, when the client takes longer than `patience_s`."""
        deadline_s = time.monotonic() + patience_s
        for record in records:
            if self._client is None:
                return False
            self._transmissions += 1
            try:
                self._client.settimeout(max(0.001, deadline_s - time.monotonic()))
                self._client.sendall(frame_record(record, self._transmissions))
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
        return self._deframer.feed(data)

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            if self._server is not None:
                self._client, _ = self._server.accept()
                self._client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self.connections += 1
                self._deframer = Deframer(MAX_REQUEST_BYTES)

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
