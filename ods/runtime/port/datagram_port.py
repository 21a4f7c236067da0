"""A UDP port at which a device sends, to this machine or to a multicast group: each read is one datagram."""

import ipaddress
import socket
from collections import Counter
from typing import ClassVar, NamedTuple

from ods.runtime.port.address import UdpAddress
from ods.runtime.port.port import PortError
from ods.runtime.port.udp_port import UdpPort

BUFFER_BYTES = 1 << 20
"""Asked for: datagrams come in fragments, one after the other."""
_ALL_GROUPS = 49
"""IP_MULTICAST_ALL of <linux/in.h>: 0, only groups that this socket has joined."""


class DatagramSource(NamedTuple):
    """Whose datagrams are wanted."""

    interface: str = ""
    """IPv4 address of the interface of this machine that joins the group; "": the one of the routing table."""
    sender: str = ""
    """IP address; "": anybody's."""


class DatagramPort(UdpPort):
    """Shares its port with other programs of this machine that listen to the same group."""

    ending: ClassVar[bytes] = b""

    def __init__(
        self, address: UdpAddress, source: DatagramSource, pauses_s: tuple[float, float], counters: "Counter[str]"
    ) -> None:
        """Make a closed port; pauses_s: shortest and longest pause before it is tried again."""
        super().__init__(address, source.sender or None, pauses_s, counters)
        self._interface = source.interface

    def _begin_opening(self, _now_ns: int) -> None:
        host = ipaddress.ip_address(self._address.host)
        if host.version == 6 and host.is_multicast:
            raise PortError("only IPv4 groups are joined")
        family = socket.AF_INET6 if host.version == 6 else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM | socket.SOCK_NONBLOCK)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        if not host.is_multicast:
            self._socket.bind(self._address)
            return
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.setsockopt(socket.IPPROTO_IP, _ALL_GROUPS, 0)
        self._socket.bind(("", self._address.port))  # so that what is sent to this machine alone is received, too
        joined = host.packed + ipaddress.IPv4Address(self._interface or "0.0.0.0").packed
        try:
            self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, joined)
        except OSError as error:
            where = f"the interface with {self._interface}" if self._interface else "any interface"
            raise PortError(f"cannot join {host} at {where}: {error.strerror}") from None
