"""Where the sonar is: a serial device, or a TCP address written as a URL."""

import ipaddress
from typing import NamedTuple
from urllib.parse import urlsplit

SEVEN_K_CENTER, SERIAL_SERVER = "tcp", "socket"


class TcpAddress(NamedTuple):
    """A TCP address and what speaks there."""

    host: str
    """IPv4 or IPv6."""
    port: int
    framed: bool
    """True: a 7k center, with network frames and subscriptions; False: the bare bytes of a serial line."""


def tcp_address(port: str) -> TcpAddress | None:
    """Return the address that a `port` setting names, None when it is a device path. Raises ValueError, one line."""
    if "://" not in port:
        return None
    example = f'such as "{SEVEN_K_CENTER}://192.168.0.5:7000"'
    url = urlsplit(port)
    if url.scheme not in (SEVEN_K_CENTER, SERIAL_SERVER):
        raise ValueError(f"port: {port}: neither a device nor an address {example}")
    try:
        host, number = str(ipaddress.ip_address(url.hostname or "")), url.port
    except ValueError:
        raise ValueError(f"port: {port}: needs an IP address, {example}: looking up a name would block") from None
    if not number:
        raise ValueError(f"port: {port}: needs a port number, {example}")
    return TcpAddress(host, number, url.scheme == SEVEN_K_CENTER)
