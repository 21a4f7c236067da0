"""Settings of what other computers may receive: an address and its topics."""

import ipaddress
from urllib.parse import urlsplit

from ods.base.settings import Settings

EXAMPLE = 'such as "tcp://192.168.2.10:5600"'


class ListenSettings(Settings, frozen=True):
    """An address for other computers."""

    at: str
    """"tcp://192.168.2.10:5600": this computer's IP address (0.0.0.0: all) and a port."""
    topics: list[str]
    """Such as ["obstacles", "health"]."""

    def __post_init__(self) -> None:
        _refuse_no_address(self.at)
        if not self.topics:
            raise ValueError("topics: must name at least one topic")


def _refuse_no_address(at: str) -> None:
    """Raises ValueError, one line that names the key."""
    try:
        url = urlsplit(at)
        address, port = ipaddress.ip_address(url.hostname or ""), url.port
    except ValueError:
        raise ValueError(f"at: {at}: needs an IP address and a port, {EXAMPLE}; names are not resolved") from None
    if url.scheme != "tcp" or not port or url.path or url.query:
        raise ValueError(f"at: {at}: expected an address and a port, {EXAMPLE}")
    if address.is_multicast or str(address) == "255.255.255.255":
        raise ValueError(f"at: {at}: must be an address of one interface, {EXAMPLE}")
