"""Address of a device: a serial device, or a network address written as a URL."""

import ipaddress
from typing import Literal, NamedTuple
from urllib.parse import urlsplit

Transport = Literal["serial", "tcp", "socket", "udp"]
"""serial: a device; tcp: the sonar's own network protocol; socket: a serial server, the bare bytes of a serial line;
udp: datagrams, to this machine or to a multicast group."""
UDP_EXAMPLE = 'such as "udp://0.0.0.0:10110"'
PORT_FORMS: dict[Transport, str] = {
    "serial": "/dev/DEVICE", "tcp": "tcp://HOST:PORT", "socket": "socket://HOST:PORT", "udp": "udp://ADDRESS:PORT",
}  # fmt: skip
"""How a `port` setting names each of them."""
_URL_TRANSPORTS: dict[str, Transport] = {"tcp": "tcp", "socket": "socket"}


class TcpAddress(NamedTuple):
    """A TCP address and what speaks there."""

    host: str
    """IPv4 or IPv6."""
    port: int
    transport: Transport
    """"tcp" or "socket"."""


def tcp_address(port: str) -> TcpAddress | None:
    """Return the address that a `port` setting names, None when it is a device path, or one of UDP.

    Raises ValueError, one line.
    """
    if "://" not in port or urlsplit(port).scheme == "udp":
        return None
    example = 'such as "tcp://192.168.0.5:7000"'
    url = urlsplit(port)
    transport = _URL_TRANSPORTS.get(url.scheme)
    if transport is None:
        raise ValueError(f"port: {port}: neither a device nor an address {example}")
    return TcpAddress(*host_and_number(port, example), transport)


class UdpAddress(NamedTuple):
    """Where to listen."""

    host: str
    """IP address of this machine; 0.0.0.0: any; or that of a multicast group, where the user of the port says so."""
    port: int


def udp_address(port: str) -> UdpAddress | None:
    """Return the address of a `port` setting, None when it is no udp:// one. Raises ValueError, one line."""
    return UdpAddress(*host_and_number(port, UDP_EXAMPLE)) if urlsplit(port).scheme == "udp" else None


def host_and_number(port: str, example: str) -> tuple[str, int]:
    """Return the IP address and the port number of a URL. Raises ValueError, one line with the `example`."""
    url = urlsplit(port)
    try:
        host = str(ipaddress.ip_address(url.hostname or ""))
    except ValueError:
        raise ValueError(f"port: {port}: needs an IP address, {example}: looking up a name would block") from None
    try:
        number = url.port
    except ValueError:  # no number, or none of 16 bits
        number = None
    if not number:
        raise ValueError(f"port: {port}: needs a port number from 1 to 65535, {example}")
    return host, number


def refuse_no_ip_address(key: str, text: str | None) -> None:
    """Raise ValueError, one line that names the key, for what is no IP address; nothing set is fine."""
    try:
        ipaddress.ip_address(text or "0.0.0.0")
    except ValueError:
        raise ValueError(f"{key}: {text}: not an IP address, such as 192.168.0.7: no name is looked up") from None


def transport_of(port: str) -> Transport:
    """Return what a `port` setting names. Raises ValueError, one line."""
    if udp_address(port):
        return "udp"
    address = tcp_address(port)
    return address.transport if address else "serial"
