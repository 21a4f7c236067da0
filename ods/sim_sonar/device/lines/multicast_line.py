"""The far end of a UDP port: datagrams to a multicast group on this computer's own interface, as a sonar sends them."""

import socket

from ods.sim_sonar.device.lines.tcp_line import HOST


class MulticastLine:
    """Sends each record as one datagram; nobody need listen."""

    needs_subscription = False

    def __init__(self, group: str, port: int) -> None:
        self.lost_bytes = 0
        self.connections = 1
        self._to = group, port
        self._socket: socket.socket | None = None
        self.plug()

    def plug(self) -> None:
        """Send again."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(HOST))
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_LOOP, 1)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)  # it leaves this computer never

    def unplug(self) -> None:
        """Send no more."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def write(self, records: list[bytes], _patience_s: float) -> bool:
        """Send datagrams; return whether all of them went out."""
        for record in records:
            try:
                if self._socket is None:
                    return False
                self._socket.sendto(record, self._to)
            except OSError:
                self.lost_bytes += len(record)
                return False
        return True

    def read(self) -> bytes:
        """Nothing is ever sent to it."""
        return b""
