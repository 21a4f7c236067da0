"""The network interface that is named in the configuration, and how DDS is bound to it and to nothing else."""

import socket
from xml.sax.saxutils import quoteattr

import psutil

from ods.bridge.settings import LOOPBACK, Ros2Settings

FAST_DDS = "1.15"
"""Its vendor id. Kilted's sends type information that Cyclone cannot read, and would then not be sent anything."""
MOST_NODES = 99
"""Participants on a computer that are looked for, where there is no multicast."""


def address_of(interface: str) -> str:
    """Return an interface's IPv4 address. Raises OSError, which says what is wrong, where it has none or is down."""
    state = psutil.net_if_stats().get(interface)
    if state is None:
        raise OSError("there is no such interface")
    if not state.isup:
        raise OSError("the interface is down")
    for each in psutil.net_if_addrs().get(interface, []):
        if each.family == socket.AF_INET:
            return str(each.address)
    raise OSError("the interface has no IPv4 address")


def configuration(settings: Ros2Settings) -> str:
    """Return Cyclone's configuration."""
    peers = [*(["127.0.0.1"] if settings.interface == LOOPBACK else []), *settings.peers]
    named = "".join(f"<Peer address={quoteattr(peer)}/>" for peer in peers)
    return (
        "<CycloneDDS><Domain Id='any'><General>"
        f"<Interfaces><NetworkInterface name={quoteattr(settings.interface)}/></Interfaces>"
        f"<AllowMulticast>{'true' if settings.multicast else 'false'}</AllowMulticast>"
        "</General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
        f"<MaxAutoParticipantIndex>{MOST_NODES}</MaxAutoParticipantIndex><Peers>{named}</Peers></Discovery>"
        f"<Compatibility><IgnoreTypeInformation>{FAST_DDS}</IgnoreTypeInformation></Compatibility>"
        "</Domain></CycloneDDS>"
    )
