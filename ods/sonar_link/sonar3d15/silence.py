"""Why a Sonar 3D-15 sends no range image, in plain words, the likeliest cause first. Pure."""

import ipaddress
from collections import Counter
from typing import NamedTuple

from ods.runtime.port.address import UdpAddress
from ods.runtime.port.datagram_port import DatagramSource

FALLBACK = "192.168.194.96"
"""The sonar has this address always, whatever else."""
DAMAGED = "bad_checksum", "truncated_record"
FOREIGN = "unknown_message", "overlong_record", "short_record"


class Evidence(NamedTuple):
    """Evidence for the reason why no ping comes."""

    address: UdpAddress
    source: DatagramSource
    kinds: "Counter[str]"
    """Complete messages by name."""
    counters: "Counter[str]"
    """Counters of damaged data."""
    images: str
    """What range images are called."""


def why(known: Evidence) -> str:
    """Return the reason, or what to check."""
    if known.kinds[known.images]:
        return "its range images cannot be decoded, or have stopped: see the counters; is it on, and in the water?"
    if known.kinds:
        return f"it sends {', '.join(sorted(known.kinds))}, not range images: are its acoustics on (see its web page)?"
    if any(known.counters[name] for name in DAMAGED):
        return "its packets arrive damaged or truncated: check cable and switch"
    if any(known.counters[name] for name in FOREIGN):
        return f"the data at UDP port {known.address.port} are not packets of a Sonar 3D-15: is it another program's?"
    if known.counters["stranger_datagrams"]:
        return f"datagrams come, but none from {known.source.sender}: sonar.sonar3d15.sender is not the sonar's address"
    return _silent(known)


def _silent(known: Evidence) -> str:
    port = known.address.port
    firewall = f"a firewall must allow incoming UDP {port}"
    sonar = known.source.sender or FALLBACK
    on = f"is the sonar on, which boots for up to 90 s, and are its acoustics on (http://{sonar})"
    if not ipaddress.ip_address(known.address.host).is_multicast:
        return f"nothing comes: {on}? Is it set to send by unicast to this computer, port {port}? {firewall}"
    interface = (
        f"does the interface with {known.source.interface} lead to it"
        if known.source.interface
        else "does the route lead to it (otherwise set sonar.sonar3d15.interface to this computer's address there)"
    )
    return (
        f"nothing comes from the group {known.address.host}: {on}? Is it set to multicast, and {interface}? "
        f"It must be in the network of {sonar} (`ip route get {sonar}`); {firewall}, and a switch the group"
    )
