"""Settings of the `bridge` package."""

import ipaddress
from typing import Annotated, Literal, NamedTuple
from urllib.parse import urlsplit

import msgspec

from ods.base.settings import Settings

BROADCAST = ipaddress.ip_address("255.255.255.255")
EXAMPLE = 'such as "udp://192.168.2.5:5005"'


class Destination(NamedTuple):
    """Where datagrams go."""

    host: str
    """IPv4 or IPv6."""
    port: int


def destination_of(to: str) -> Destination:
    """Return the receiver that a `to` setting names. Raises ValueError, one line that names the key."""
    try:
        url = urlsplit(to)
        address, port = ipaddress.ip_address(url.hostname or ""), url.port
    except ValueError:
        raise ValueError(f"to: {to}: needs an IP address and a port, {EXAMPLE}: no name is looked up") from None
    if url.scheme != "udp" or not port or url.path or url.query:
        raise ValueError(f"to: {to}: expected an address and a port, {EXAMPLE}")
    if address.is_multicast or address.is_unspecified or address == BROADCAST:
        raise ValueError(f"to: {to}: must be one receiver, {EXAMPLE}")
    return Destination(str(address), port)


class UdpSettings(Settings, frozen=True):
    """Where a bridge sends, and how much."""

    to: str
    """One receiver, such as "udp://192.168.2.5:5005": an IP address and a port. No multicast, no broadcast."""
    most_hz: Annotated[float, msgspec.Meta(gt=0.0, le=100.0)] = 10.0
    """Lists sent a second, at most."""
    most_obstacles: Annotated[int, msgspec.Meta(ge=1, le=100)] = 50
    """Of each list only so many obstacles are sent: the nearest."""

    def __post_init__(self) -> None:
        destination_of(self.to)


class JsonSettings(UdpSettings, frozen=True):
    """JSON: one datagram a list."""

    most_bytes: Annotated[int, msgspec.Meta(ge=1000, le=65_000)] = 16_000
    """Longest datagram; obstacles beyond it are left out, the farthest first. Over 1472 bytes Ethernet sends it in
    pieces, and all of it is lost with one."""


class TtmSettings(UdpSettings, frozen=True):
    """NMEA 0183 TTM: a sentence and a datagram an obstacle."""

    most_hz: Annotated[float, msgspec.Meta(gt=0.0, le=100.0)] = 2.0
    """Lists sent a second, at most."""
    talker: Annotated[str, msgspec.Meta(pattern="^[A-Z]{2}$")] = "RA"
    """Talker of the sentences: many displays take targets of a radar only."""


class MoosSettings(UdpSettings, frozen=True):
    """MOOS-IvP: GIVEN_OBSTACLE to pShare, a datagram an obstacle."""

    duration_s: Annotated[float, msgspec.Meta(ge=0.5, le=60.0)] = 2.0
    """pObstacleMgr forgets an obstacle of which it has heard nothing for so long."""
    sigmas: Annotated[float, msgspec.Meta(ge=0.0, le=5.0)] = 2.0
    """Polygons are wider than the obstacle by so many standard deviations of its place and radius."""


class MavlinkSettings(UdpSettings, frozen=True):
    """MAVLink 2: OBSTACLE_DISTANCE or OBSTACLE_DISTANCE_3D."""

    form: Literal["distance", "3d"] = "distance"
    """distance: 72 sectors around the vehicle in one message; 3d: a message for each obstacle, and for each sector that
    is not free."""
    unknown: Literal["obstacle", "unknown"] = "obstacle"
    """Water that is not known to be empty is sent as an obstacle, or as unknown, which ArduPilot takes for free."""
    unknown_m: Annotated[float, msgspec.Meta(ge=0.1, le=100.0)] = 1.0
    """An obstacle that stands for unknown water is never nearer, m."""
    near_m: Annotated[float, msgspec.Meta(ge=0.0, le=100.0)] = 3.0
    """Water so near counts as looked at if what follows is clear, m: no sonar sees what is next to it."""
    most_m: Annotated[float, msgspec.Meta(ge=1.0, le=600.0)] = 30.0
    """What is farther away is not sent, m."""
    system_id: Annotated[int, msgspec.Meta(ge=1, le=255)] = 1
    """Of the vehicle, SYSID_THISMAV of its autopilot."""
    component_id: Annotated[int, msgspec.Meta(ge=1, le=255)] = 196
    """Of this sender; 196 is MAV_COMP_ID_OBSTACLE_AVOIDANCE."""


class BridgeSettings(Settings, frozen=True):
    """The bridges: each runs where its table is given."""

    json: JsonSettings | None = None
    ttm: TtmSettings | None = None
    moos: MoosSettings | None = None
    mavlink: MavlinkSettings | None = None

    def given(self) -> list[str]:
        """Return the names of the bridges that are to run."""
        return [name for name in self.__struct_fields__ if getattr(self, name) is not None]


class BridgeConfig(Settings, frozen=True):
    """What a bridge's process reads of the configuration."""

    bridge: BridgeSettings = BridgeSettings()
