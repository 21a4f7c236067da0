"""Settings of the `bridge` package."""

import ipaddress
from typing import Annotated, Literal, NamedTuple
from urllib.parse import urlsplit

import msgspec

from ods.base.settings import Settings

BROADCAST = ipaddress.ip_address("255.255.255.255")
LOOPBACK = "lo"
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
        raise ValueError(f"to: {to}: needs an IP address and a port, {EXAMPLE}; names are not resolved") from None
    if url.scheme != "udp" or not port or url.path or url.query:
        raise ValueError(f"to: {to}: expected an address and a port, {EXAMPLE}")
    if address.is_multicast or address.is_unspecified or address == BROADCAST:
        raise ValueError(f"to: {to}: must be one receiver, {EXAMPLE}")
    return Destination(str(address), port)


class ListSettings(Settings, frozen=True, kw_only=True):
    """How much a bridge sends."""

    most_hz: Annotated[float, msgspec.Meta(gt=0.0, le=100.0)] = 10.0
    most_obstacles: Annotated[int, msgspec.Meta(ge=1, le=100)] = 50
    """The nearest."""


class UdpSettings(ListSettings, frozen=True, kw_only=True):
    """Where a bridge sends, and how much."""

    to: str
    """"udp://192.168.2.5:5005"; no multicast, no broadcast."""

    def __post_init__(self) -> None:
        destination_of(self.to)


class JsonSettings(UdpSettings, frozen=True):
    """JSON, one datagram per list."""

    most_bytes: Annotated[int, msgspec.Meta(ge=1000, le=65_000)] = 16_000
    """Longest datagram: the farthest obstacles are omitted. Ethernet fragments more than 1472 bytes, and one lost
    fragment loses all."""


class TtmSettings(UdpSettings, frozen=True):
    """NMEA 0183 TTM, one datagram per obstacle."""

    most_hz: Annotated[float, msgspec.Meta(gt=0.0, le=100.0)] = 2.0
    talker: Annotated[str, msgspec.Meta(pattern="^[A-Z]{2}$")] = "RA"
    """Many displays accept targets of a radar only."""


class MoosSettings(UdpSettings, frozen=True):
    """GIVEN_OBSTACLE to pShare, one datagram per obstacle."""

    duration_s: Annotated[float, msgspec.Meta(ge=0.5, le=60.0)] = 2.0
    """pObstacleMgr drops an obstacle without an update for this time."""
    sigmas: Annotated[float, msgspec.Meta(ge=0.0, le=5.0)] = 2.0
    """Polygons are widened by this many standard deviations."""


Ros2Topic = Literal["obstacles", "markers", "tracks", "clearance", "odometry", "diagnostics", "tf", "image"]
FrameName = Annotated[str, msgspec.Meta(pattern="^[A-Za-z][A-Za-z0-9_]*(/[A-Za-z0-9_]+)*$", max_length=100)]


class Ros2Settings(ListSettings, frozen=True):
    """DDS: needs `pip install 'ods[ros2]'`."""

    interface: Annotated[str, msgspec.Meta(pattern="^[A-Za-z0-9_][A-Za-z0-9_.-]{0,14}$")] = "lo"
    """The only network interface used. "lo": this computer."""
    domain: Annotated[int, msgspec.Meta(ge=0, le=232)] = 0
    """ROS_DOMAIN_ID of the nodes."""
    peers: Annotated[tuple[str, ...], msgspec.Meta(max_length=16)] = ()
    """IP addresses of the computers with the nodes; "lo" needs none."""
    multicast: bool = False
    """Any node of the network may discover this bridge and receive its messages."""
    namespace: Annotated[str, msgspec.Meta(pattern="^(/[A-Za-z][A-Za-z0-9_]*)+$", max_length=100)] = "/ods"
    """Of the topics, except /diagnostics and /tf."""
    map_frame: FrameName = "map"
    """ENU, with its origin at the site."""
    vehicle_frame: FrameName = "base_link"
    """The vehicle's origin, FLU; the sonar's frames are "sonar" and "sonar_fan"."""
    send: Annotated[tuple[Ros2Topic, ...], msgspec.Meta(min_length=1)] = (
        "obstacles", "markers", "tracks", "clearance", "odometry", "diagnostics",
    )  # fmt: skip
    """Topics (docs/bridges/ros2.md); `tf` only where no other node publishes the vehicle's position."""
    image_hz: Annotated[float, msgspec.Meta(gt=0.0, le=20.0)] = 2.0
    """At most."""
    image_bytes: Annotated[int, msgspec.Meta(ge=1000, le=4_000_000)] = 50_000
    """Larger images get fewer range samples, each the maximum of several."""

    def __post_init__(self) -> None:
        for peer in self.peers:
            _refuse_no_computer(peer)
        if self.interface != LOOPBACK and not self.peers and not self.multicast:
            raise ValueError(f"peers: name the nodes' computers on {self.interface}, or set multicast = true")


def _refuse_no_computer(peer: str) -> None:
    """Raise ValueError, which names the key, for what is no address of one computer."""
    try:
        address = ipaddress.ip_address(peer)
    except ValueError:
        raise ValueError(f'peers: {peer}: needs an IP address, such as "192.168.2.5"; names are not resolved') from None
    if address.is_multicast or address.is_unspecified or address == BROADCAST:
        raise ValueError(f"peers: {peer}: must be one computer")


class MavlinkSettings(UdpSettings, frozen=True):
    """MAVLink 2: OBSTACLE_DISTANCE or OBSTACLE_DISTANCE_3D."""

    form: Literal["distance", "3d"] = "distance"
    """distance: 72 sectors in one message; 3d: a message for each obstacle and each sector that is not free."""
    unknown: Literal["obstacle", "unknown"] = "obstacle"
    """Unknown water is sent as an obstacle, or as unknown, which ArduPilot treats as free."""
    unknown_m: Annotated[float, msgspec.Meta(ge=0.1, le=100.0)] = 1.0
    """Smallest distance of an obstacle that represents unknown water."""
    near_m: Annotated[float, msgspec.Meta(ge=0.0, le=100.0)] = 3.0
    """Unobserved water up to here counts as clear if the water beyond is, because no sonar sees its immediate
    surroundings."""
    most_m: Annotated[float, msgspec.Meta(ge=1.0, le=600.0)] = 30.0
    """Largest distance sent."""
    system_id: Annotated[int, msgspec.Meta(ge=1, le=255)] = 1
    """SYSID_THISMAV of the vehicle's autopilot."""
    component_id: Annotated[int, msgspec.Meta(ge=1, le=255)] = 196
    """Of this sender; 196 is MAV_COMP_ID_OBSTACLE_AVOIDANCE."""


class BridgeSettings(Settings, frozen=True):
    """Each bridge runs where its table is given."""

    json: JsonSettings | None = None
    ttm: TtmSettings | None = None
    moos: MoosSettings | None = None
    ros2: Ros2Settings | None = None
    mavlink: MavlinkSettings | None = None

    def given(self) -> list[str]:
        """Return the names of the bridges that are to run."""
        return [name for name in self.__struct_fields__ if getattr(self, name) is not None]


class BridgeConfig(Settings, frozen=True):
    """Configuration of a bridge process."""

    bridge: BridgeSettings = BridgeSettings()
