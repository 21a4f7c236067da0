"""Settings of the `nav_bridge` package."""

import re
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from ods.base.choices import none_of
from ods.base.frames.mounting import Lever
from ods.base.geodesy import SiteSettings
from ods.base.settings import NonNegative, NonNegativeInt, Positive, PositiveInt, Seconds, Settings, slider, unit
from ods.runtime.port.address import refuse_no_ip_address, tcp_address, udp_address

NodeId = Annotated[int, msgspec.Meta(ge=1, le=127)]
OptionValue = str | int | float | bool
StatusBit = Annotated[int, msgspec.Meta(ge=0, le=63)]

USUAL_INTERFACES = frozenset({"socketcan", "slcan", "pcan", "kvaser", "virtual"})
"""Known without python-can, so that only the nav process has to load it."""
REFUSED_INTERFACES = {
    "udp_multicast": "it leaves the vehicle through the default route, and one stray datagram ends its reader",
}


class CanSettings(Settings, frozen=True):
    """CAN by python-can."""

    interface: str = "socketcan"
    """Driver: socketcan, slcan, pcan, kvaser, virtual ..."""
    channel: str = "can0"
    """Network interface, or device of the adapter."""
    bitrate: PositiveInt | None = None
    """bit/s; not for socketcan."""
    options: dict[str, OptionValue] = msgspec.field(default_factory=dict)
    """For python-can's bus class, such as slcan's tty_baudrate."""
    receive_buffer_bytes: PositiveInt = 8 * 1024 * 1024
    """The kernel's (socketcan)."""
    silence_s: Seconds = 1.0
    """Without a frame for this long the interface is reopened."""

    def __post_init__(self) -> None:
        why = REFUSED_INTERFACES.get(self.interface)
        if why:
            raise ValueError(f"interface: {self.interface} is not allowed: {why}")
        if self.interface not in USUAL_INTERFACES:
            from can.interfaces import VALID_INTERFACES  # with those of its plug-ins

            if self.interface not in VALID_INTERFACES:
                usable = sorted(VALID_INTERFACES - REFUSED_INTERFACES.keys())
                raise ValueError(f"interface: {none_of(self.interface, usable)}")
        if not self.channel:
            raise ValueError("channel: must not be empty")


class LimitSettings(Settings, frozen=True):
    """Limits beyond which poses are dropped and counted."""

    horizontal_m: Positive = 100_000.0
    """From the site's origin, along north and east."""
    height_m: NonNegative = 100.0
    """Above the datum."""
    depth_m: Positive = 12_000.0
    """Below the datum."""
    speed: Annotated[Positive, unit("m/s")] = 30.0
    """Along each body axis, m/s."""
    age_s: Annotated[Positive, slider(0.1, 5.0, unit="s")] = 1.0
    """From the pose's instant to its arrival."""
    altitude_m: Annotated[float, msgspec.Meta(gt=0.0, le=20_000.0)] = 500.0
    """Over the bottom; a larger one is omitted from its pose."""


class SigmaSettings(Settings, frozen=True):
    """Standard deviations (sigmas) of an INS that reports none."""

    position_m: Annotated[Positive, slider(0.01, 50.0, log=True, unit="m")] = 0.5
    """North, east and down."""
    attitude_rad: Annotated[Positive, slider(1e-4, 0.2, log=True, unit="rad")] = 0.005
    """Roll, pitch and yaw."""
    altitude_m: Annotated[Positive, slider(0.01, 10.0, log=True, unit="m")] = 0.3
    """Over the bottom."""


class ObjectSettings(Settings, frozen=True):
    """A pose field with a factor."""

    field: str
    factor: float | None = None
    """Field's unit per count; left out: `Factor` of the EDS, else 1."""

    def __post_init__(self) -> None:
        if self.factor == 0.0:
            raise ValueError("factor: must not be 0")


POSE_OBJECTS: dict[str, str | ObjectSettings] = {
    "0x2000": "sequence",
    "0x2001": "status",
    "0x2002": "time_of_day",
    "0x2010:1": "north",
    "0x2010:2": "east",
    "0x2010:3": "down",
    "0x2011:1": "roll",
    "0x2011:2": "pitch",
    "0x2011:3": "yaw",
    "0x2012:1": "u",
    "0x2012:2": "v",
    "0x2012:3": "w",
    "0x2013:1": "sigma_horizontal",
    "0x2013:2": "sigma_down",
    "0x2013:3": "sigma_tilt",
    "0x2013:4": "sigma_yaw",
    "0x2014": "over_bottom",
}
"""Those of config/ins.eds and, the last, of config/ins_altitude.eds."""
STATUS_BITS: dict[str, StatusBit] = {"position": 0, "attitude": 1, "velocity": 2, "time_of_day": 3, "altitude": 4}


class CanopenSettings(Settings, frozen=True):
    """The INS, and this process as a node."""

    ins_eds: Path
    """EDS or DCF file."""
    node_eds: Path
    """EDS file of this node."""
    ins_node_id: NodeId = 5
    node_id: NodeId = 32
    """Of this node."""
    objects: dict[str, str | ObjectSettings] = msgspec.field(default_factory=lambda: dict(POSE_OBJECTS))
    """Pose field of each object, `"0x2010:1" = "north"` or `{field = "latitude", factor = 1e-7}`. Replaces the whole
    default table (docs/navigation/canopen.md)."""
    status_bits: dict[str, StatusBit] | None = None
    """Bit of the status object set while position, attitude, velocity, time_of_day or altitude is valid; parts without
    a
    bit are always valid. Without this table: bits 0 to 4 in that order, if there is a status object."""
    epoch_window_s: Seconds = 0.005
    """Without sequence numbers: longest time from first to last PDO of an instant; less than the INS's period."""
    start_ins: bool = False
    """NMT start to the INS after boot-up and while it is pre-operational; without heartbeat, while there is no pose."""
    sync_period_s: Annotated[float, msgspec.Meta(ge=0.0, le=60.0)] = 0.0
    """Of this node's SYNC; 0: none."""
    heartbeat_timeout_s: Annotated[float, msgspec.Meta(ge=0.0, le=65.0)] = 1.0
    """Of the INS; 0: it sends none."""
    heartbeat_period_s: Annotated[float, msgspec.Meta(ge=0.0, le=65.0)] = 0.5
    """Of this node; 0: none."""
    emcy_inhibit_s: Annotated[float, msgspec.Meta(ge=0.0, le=6.5)] = 0.1
    """Least time between emergency messages."""
    serial_number: Annotated[int, msgspec.Meta(ge=0, le=0xFFFFFFFF)] = 0
    """Of this node's identity object."""

    def __post_init__(self) -> None:
        if self.node_id == self.ins_node_id:
            raise ValueError(f"node_id: {self.node_id} is the INS's own (ins_node_id)")
        bits = self.status_bits or {}
        if unknown := bits.keys() - STATUS_BITS.keys():
            raise ValueError(f"status_bits: {none_of(min(unknown), STATUS_BITS)}")
        fields = [entry if isinstance(entry, str) else entry.field for entry in self.objects.values()]
        if bits and "status" not in fields:
            raise ValueError('status_bits: no object of nav.canopen.objects is the "status" that has these bits')


class PartSettings(Settings, frozen=True):
    """One signal of a DBC file: sign x factor x value."""

    signal: str
    """MESSAGE.SIGNAL."""
    unit: str | None = None
    """Of the signal, if the DBC has none or a wrong one."""
    factor: float | None = None
    """Pose field's unit per unit of the signal, instead of `unit`."""
    sign: Literal[1, -1] = 1
    """-1: inverted, such as a depth reported as altitude."""
    any_value: bool = False
    """Accept values outside the DBC's range."""

    def __post_init__(self) -> None:
        if self.unit is not None and self.factor is not None:
            raise ValueError("factor: set either unit or factor")
        if self.factor is not None and self.factor <= 0.0:
            raise ValueError("factor: must be positive; `sign` reverses a signal")


class SignalSettings(PartSettings, frozen=True):
    """Pose field = sign x factor x value + plus + offset."""

    plus: str | PartSettings | None = None
    """A second signal, such as a fraction or lower bits."""
    offset: float = 0.0
    """In the field's unit."""


class HeldSettings(Settings, frozen=True):
    """Newest values of a message with its own rate."""

    max_age_s: Seconds = 0.5
    """With older values there is no pose."""
    growth_m_s: NonNegative = 0.2
    """Growth of a position's sigma with its age."""
    growth_rad_s: NonNegative = 0.1
    """Growth of an angle's sigma with its age."""


class TimeSettings(Settings, frozen=True):
    """The INS's clock."""

    signal: str
    """MESSAGE.SIGNAL."""
    unit: str | None = None
    """As of other signals."""
    wraps_at: Positive | None = None
    """Where it restarts from 0; left out: an integer's number of bits, others never."""


class ValiditySettings(Settings, frozen=True):
    """A status required for poses to be used."""

    signal: str
    """MESSAGE.SIGNAL as transmitted, without factor and offset."""
    mask: NonNegativeInt | None = None
    """Bits that count; none: all."""
    accept: list[NonNegativeInt] | None = None
    """Values after the mask; none: all bits of the mask set."""
    says: str = "pose"
    """Its name in the health report."""
    holds_s: Seconds = 2.0
    """An older status does not count."""

    def __post_init__(self) -> None:
        if self.mask is None and self.accept is None:
            raise ValueError("mask: give mask, accept or both")
        if self.mask == 0:
            raise ValueError("mask: 0 accepts every value")
        if self.accept == []:
            raise ValueError("accept: no value would be accepted")


class DbcSettings(Settings, frozen=True):
    """CAN frames described by a DBC file; nothing is sent."""

    file: Path
    signals: dict[str, str | SignalSettings]
    """MESSAGE.SIGNAL of each pose field (docs/navigation/dbc.md), or a table."""
    time: str | TimeSettings | None = None
    """Signal of the INS's clock; left out: arrival counts."""
    epoch: list[str] | None = None
    """Messages of one instant in sending order; left out: found by the silence after the last."""
    sequence: list[str] = msgspec.field(default_factory=list)
    """MESSAGE.SIGNAL of a counter or time stamp that all messages of an instant share; then order does not matter."""
    held: dict[str, HeldSettings] = msgspec.field(default_factory=dict)
    """Messages with a rate of their own."""
    window_s: Seconds = 0.008
    """Longest time from an instant to its last message; shorter than the INS's period."""
    valid: list[ValiditySettings] = msgspec.field(default_factory=list)
    """Conditions for using a pose."""
    source_address: Annotated[int, msgspec.Meta(ge=0, le=253)] | None = None
    """J1939 and NMEA 2000: of the messages; left out: any."""


NMEA_CHOICES: dict[str, tuple[str, ...]] = {
    "place": ("GGA", "RMC"),
    "depth": ("GGA", "DPT", "DBT", "DBS", "TS"),
    "attitude": ("PASHR", "PSXN", "SA"),
    "heading": ("PASHR", "PSXN", "HDT", "SA"),
    "velocity": ("VTG", "RMC", "BS", "BE"),
    "accuracy": ("GST",),
    "altitude": ("DPT", "DBT", "BD"),
}
"""Sentences that may carry each part of a pose: NMEA 0183, PASHR, PSXN, and PD6's two letters."""
TALKER = re.compile(r"^(?!P)[A-Z]{2}(?=[A-Z]{3}$)")
"""Before a sentence's name; no talker begins with P, as makers' sentences do."""


class NmeaSettings(Settings, frozen=True):
    """NMEA 0183 or PD6 on one line; nothing is sent. Each part of the pose names its sentence: GGA of any talker, or
    INGGA of one."""

    port: str
    """Serial device; "udp://0.0.0.0:10110", to receive datagrams; "socket://192.168.0.5:4001", a serial server."""
    baud: PositiveInt = 115200
    """bit/s."""
    sender: str | None = None
    """IP address of the datagrams' sender; none: any."""
    place: str = "GGA"
    """GGA or RMC."""
    depth: str = "GGA"
    """GGA: altitude above mean sea level; DPT, DBT, DBS, TS: depth below the surface."""
    attitude: str = "PASHR"
    """PASHR, PSXN (kind 23) or SA: roll and pitch; each makes a pose."""
    heading: str = "PASHR"
    """PASHR, PSXN, HDT or SA."""
    velocity: str = "VTG"
    """VTG, RMC (nothing vertical), BS or BE (a Doppler log over ground)."""
    accuracy: str | None = None
    """GST; none: `nav.sigma.position_m` holds."""
    altitude: str | None = None
    """DPT or DBT (an echo sounder under the vehicle), or BD: altitude over the bottom."""
    accept: dict[Literal["estimated", "manual", "simulated", "unsafe"], Annotated[NonNegative, unit("m")]] = (
        msgspec.field(default_factory=lambda: {"estimated": 10.0})
    )
    """Kinds that are used although they are no fix (docs/navigation/nmea.md), each with its addition to the position's
    sigma, m: nothing for estimated ones if `accuracy` is set. Others are refused."""
    held: dict[str, HeldSettings] = msgspec.field(
        default_factory=lambda: {name: HeldSettings(max_age_s=1.5) for name in ("GGA", "RMC", "GST")}
    )
    """Age limits by name without talker. Left out: 1.5 s for GGA, RMC, GST; a sentence that is not named has 0.5 s."""

    @property
    def look_at(self) -> str:
        """What may be wrong of the line when what comes cannot be read; of a network that is less."""
        if udp_address(self.port):
            return "is nav.nmea.port right, and is what is sent there NMEA 0183?"
        server = "the serial server's " if tcp_address(self.port) else ""
        return f"are nav.nmea.port, {server}baud, ground and polarity right?"

    def __post_init__(self) -> None:
        udp_address(self.port) or tcp_address(self.port)
        refuse_no_ip_address("sender", self.sender)
        for part, usable in NMEA_CHOICES.items():
            choice = getattr(self, part)
            if choice is not None and TALKER.sub("", choice) not in usable:
                raise ValueError(f"{part}: {none_of(choice, usable)}")
        if self.altitude is not None and TALKER.sub("", self.altitude) == TALKER.sub("", self.depth):
            raise ValueError(f"altitude: {self.altitude} is already used for the depth")
        known = {name for usable in NMEA_CHOICES.values() for name in usable}
        unknown = self.held.keys() - known
        if unknown:
            raise ValueError(f"held: {none_of(min(unknown), sorted(known))}")


class NavSettings(Settings, frozen=True):
    """Source of the vehicle's pose."""

    source: Literal["canopen", "dbc", "nmea"] = "canopen"
    """Protocol of the INS; its table has the settings."""
    canopen: CanopenSettings | None = None
    dbc: DbcSettings | None = None
    nmea: NmeaSettings | None = None
    can: CanSettings = CanSettings()
    lever_arm_m: Lever = (0.0, 0.0, 0.0)
    """Point whose position and velocity the INS reports: forward, starboard, down of the body's origin."""
    stale_s: Seconds = 0.5
    """Longest time without a pose before it is reported as a problem."""
    clock_jump_s: Seconds = 0.1
    """A larger step of the INS's clock is accepted after four epochs confirm it."""
    limits: LimitSettings = LimitSettings()
    sigma: SigmaSettings = SigmaSettings()

    def __post_init__(self) -> None:
        if getattr(self, self.source) is None:
            raise ValueError(f"{self.source}: missing, as source is {self.source!r}")


class NavConfig(Settings, frozen=True):
    """The part of the configuration that the nav process reads."""

    site: SiteSettings
    nav: NavSettings
