"""Settings of the `nav_bridge` package."""

import re
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from ods.base.choices import none_of
from ods.base.geodesy import SiteSettings
from ods.base.mounting import Lever
from ods.base.settings import NonNegative, NonNegativeInt, Positive, PositiveInt, Seconds, Settings, slider, unit
from ods.runtime.port.address import tcp_address
from ods.runtime.port.udp_port import udp_address

NodeId = Annotated[int, msgspec.Meta(ge=1, le=127)]
OptionValue = str | int | float | bool
StatusBit = Annotated[int, msgspec.Meta(ge=0, le=63)]

USUAL_INTERFACES = frozenset({"socketcan", "slcan", "pcan", "kvaser", "virtual"})
"""Known without python-can, so that only the nav process has to load it."""
REFUSED_INTERFACES = {
    "udp_multicast": "it leaves the vehicle through the default route, and one stray datagram ends its reader",
}


class CanSettings(Settings, frozen=True):
    """The CAN interface, as python-can names it."""

    interface: str = "socketcan"
    """python-can's name of the driver: socketcan, slcan, pcan, kvaser, virtual ..."""
    channel: str = "can0"
    """Network interface, or device of the adapter."""
    bitrate: PositiveInt | None = None
    """Bit/s; not used by socketcan, where the network interface has its own."""
    options: dict[str, OptionValue] = msgspec.field(default_factory=dict)
    """More keyword arguments of python-can's bus class, for instance tty_baudrate of slcan."""
    receive_buffer_bytes: PositiveInt = 8 * 1024 * 1024
    """Size of the kernel's receive buffer (socketcan)."""
    silence_s: Seconds = 1.0
    """Without any frame for so long the interface is closed and opened again."""

    def __post_init__(self) -> None:
        why = REFUSED_INTERFACES.get(self.interface)
        if why:
            raise ValueError(f"interface: {self.interface} is refused: {why}")
        if self.interface not in USUAL_INTERFACES:
            from can.interfaces import VALID_INTERFACES  # with those of its plug-ins

            if self.interface not in VALID_INTERFACES:
                usable = sorted(VALID_INTERFACES - REFUSED_INTERFACES.keys())
                raise ValueError(f"interface: {none_of(self.interface, usable)}")
        if not self.channel:
            raise ValueError("channel: must not be empty")


class LimitSettings(Settings, frozen=True):
    """What a believable pose stays within; others are dropped and counted."""

    horizontal_m: Positive = 100_000.0
    """Distance from the site's origin along north and east."""
    height_m: NonNegative = 100.0
    """Height above the datum."""
    depth_m: Positive = 12_000.0
    """Depth below the datum."""
    speed: Annotated[Positive, unit("m/s")] = 30.0
    """m/s along each body axis."""
    age_s: Annotated[Positive, slider(0.1, 5.0, unit="s")] = 1.0
    """Time from the pose's instant to its arrival."""
    altitude_m: Annotated[float, msgspec.Meta(gt=0.0, le=20_000.0)] = 500.0
    """Altitude over the bottom; one beyond this, or not above 0, is left out of its pose."""


class SigmaSettings(Settings, frozen=True):
    """Standard deviations of a source that tells none."""

    position_m: Annotated[Positive, slider(0.01, 50.0, log=True, unit="m")] = 0.5
    """Of north, east and down, m."""
    attitude_rad: Annotated[Positive, slider(1e-4, 0.2, log=True, unit="rad")] = 0.005
    """Of roll, pitch and yaw, rad."""
    altitude_m: Annotated[Positive, slider(0.01, 10.0, log=True, unit="m")] = 0.3
    """Of the altitude over the bottom, m."""


class ObjectSettings(Settings, frozen=True):
    """What an object of the INS is, where its name alone does not say enough."""

    field: str
    """Name of the pose field."""
    factor: float | None = None
    """Turns raw counts into the field's unit; without it the EDS's `Factor` does, else they are one."""

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
    """An INS that speaks CANopen, and our own node."""

    ins_eds: Path
    """EDS or DCF file of the INS: which objects its PDOs carry."""
    node_eds: Path
    """EDS file of this process's own CANopen node."""
    ins_node_id: NodeId = 5
    """CANopen node id of the INS."""
    node_id: NodeId = 32
    """CANopen node id of this process."""
    objects: dict[str, str | ObjectSettings] = msgspec.field(default_factory=lambda: dict(POSE_OBJECTS))
    """Object of the INS to pose field, `"0x2010:1" = "north"` or `{field = "latitude", factor = 1e-7}`; as a whole in
    place of the default, which is that of config/ins.eds and config/ins_altitude.eds (docs/navigation/canopen.md)."""
    status_bits: dict[str, StatusBit] = msgspec.field(default_factory=lambda: dict(STATUS_BITS))
    """Bit of the status object that says that position, attitude, velocity, time_of_day or altitude (over the bottom)
    is valid; a part left out always is."""
    epoch_window_s: Seconds = 0.005
    """Without sequence numbers: time from the first to the last PDO of one instant; shorter than the time between two
    instants, s."""
    start_ins: bool = False
    """Send NMT `start remote node` to the INS after its boot-up and while it says that it is pre-operational; to one
    without heartbeat while there is no pose."""
    sync_period_s: Annotated[float, msgspec.Meta(ge=0.0, le=60.0)] = 0.0
    """Period of the SYNC that this node sends, for an INS that waits for one, s; 0: none."""
    heartbeat_timeout_s: Annotated[float, msgspec.Meta(ge=0.0, le=65.0)] = 1.0
    """Silence of the INS's heartbeat that is a problem, s; 0: it sends none."""
    heartbeat_period_s: Annotated[float, msgspec.Meta(ge=0.0, le=65.0)] = 0.5
    """Period of this node's own heartbeat, s; 0: none."""
    emcy_inhibit_s: Annotated[float, msgspec.Meta(ge=0.0, le=6.5)] = 0.1
    """Least time between two emergency messages of this node, s."""
    serial_number: Annotated[int, msgspec.Meta(ge=0, le=0xFFFFFFFF)] = 0
    """Serial number in this node's identity object."""

    def __post_init__(self) -> None:
        if self.node_id == self.ins_node_id:
            raise ValueError(f"node_id: {self.node_id} is the INS's own (ins_node_id)")
        unknown = self.status_bits.keys() - STATUS_BITS.keys()
        if unknown:
            raise ValueError(f"status_bits: {none_of(min(unknown), STATUS_BITS)}")


class PartSettings(Settings, frozen=True):
    """One signal of a DBC file: sign x factor x value."""

    signal: str
    """MESSAGE.SIGNAL, as the DBC names them."""
    unit: str | None = None
    """Unit of the signal, where the DBC tells none or a wrong one."""
    factor: float | None = None
    """Pose field's unit in one of the signal's, for units that have no name here."""
    sign: Literal[1, -1] = 1
    """-1 turns the signal round: a depth told as altitude."""
    any_value: bool = False
    """Use values outside of the range that the DBC gives the signal, too: where that is wrong."""

    def __post_init__(self) -> None:
        if self.unit is not None and self.factor is not None:
            raise ValueError("factor: give either unit or factor")
        if self.factor is not None and self.factor <= 0.0:
            raise ValueError("factor: must be positive; sign turns a signal round")


class SignalSettings(PartSettings, frozen=True):
    """A signal and what makes a pose field of it: sign x factor x value + plus + offset."""

    plus: str | PartSettings | None = None
    """A second signal of the same instant that is added: the fraction to the whole, the lower bits to the higher."""
    offset: float = 0.0
    """Added last, in the field's unit."""


class HeldSettings(Settings, frozen=True):
    """A message that comes at a rate of its own: its newest values are held."""

    max_age_s: Seconds = 0.5
    """There is no pose while they are older."""
    growth_m_s: NonNegative = 0.2
    """What a second of age adds to the standard deviation of a place, which is carried on by the velocity; m/s."""
    growth_rad_s: NonNegative = 0.1
    """And of an angle, rad/s."""


class TimeSettings(Settings, frozen=True):
    """The INS's own clock in a DBC file."""

    signal: str
    """MESSAGE.SIGNAL, as the DBC names them."""
    unit: str | None = None
    """Unit of the signal, where the DBC tells none or a wrong one."""
    wraps_at: Positive | None = None
    """Where it starts again from 0, in the signal's unit; none: an integer at its full number of bits, others never."""


class ValiditySettings(Settings, frozen=True):
    """A status that must hold for poses to be used."""

    signal: str
    """MESSAGE.SIGNAL, as the DBC names them; its integer is taken as sent, without factor and offset."""
    mask: NonNegativeInt | None = None
    """Bits that count; none: all."""
    accept: list[NonNegativeInt] | None = None
    """Values, after the mask, that are good; none: all bits of the mask set."""
    says: str = "pose"
    """What is not valid otherwise, for the health report."""
    holds_s: Seconds = 2.0
    """A status older than this is none."""

    def __post_init__(self) -> None:
        if self.mask is None and self.accept is None:
            raise ValueError("mask: give mask, accept or both")
        if self.mask == 0:
            raise ValueError("mask: 0 lets everything pass")
        if self.accept == []:
            raise ValueError("accept: no value at all would be good")


class DbcSettings(Settings, frozen=True):
    """An INS whose frames a DBC file describes. Nothing is sent."""

    file: Path
    """The DBC file."""
    signals: dict[str, str | SignalSettings]
    """Pose field to MESSAGE.SIGNAL, or to a table with more; docs/navigation/dbc.md lists the fields."""
    time: str | TimeSettings | None = None
    """The INS's clock; none: arrival is a pose's instant."""
    epoch: list[str] | None = None
    """Messages of one instant in the order of sending; none: found on the bus, where silence follows the last one."""
    sequence: list[str] = msgspec.field(default_factory=list)
    """A signal of each message of an instant, MESSAGE.SIGNAL, that has the same value in all of them, a counter or a
    time stamp: then their order does not matter."""
    held: dict[str, HeldSettings] = msgspec.field(default_factory=dict)
    """Messages that come at a rate of their own, by name; they belong to no instant."""
    window_s: Seconds = 0.008
    """An epoch must be complete so soon after its instant; shorter than the INS's period, so that no frame of a later
    instant can be in it."""
    valid: list[ValiditySettings] = msgspec.field(default_factory=list)
    """Status that must hold."""
    source_address: Annotated[int, msgspec.Meta(ge=0, le=253)] | None = None
    """J1939 and NMEA 2000: take messages of this sender; none: of whichever sends them: the parameter group counts."""


NMEA_CHOICES: dict[str, tuple[str, ...]] = {
    "place": ("GGA", "RMC"),
    "depth": ("GGA", "DPT", "DBT", "DBS", "TS"),
    "attitude": ("PASHR", "PSXN", "SA"),
    "heading": ("PASHR", "PSXN", "HDT", "SA"),
    "velocity": ("VTG", "RMC", "BS", "BE"),
    "accuracy": ("GST",),
    "altitude": ("DPT", "DBT", "BD"),
}
"""Sentences that may tell each part of a pose: NMEA 0183, PASHR, PSXN, and PD6's two letters."""
TALKER = re.compile(r"(?!PASHR$)[A-Z]{2}(?=[A-Z]{3}$)")


class NmeaSettings(Settings, frozen=True):
    """An INS, or sensors, that speak NMEA 0183 or PD6 on one line. Nothing is sent.

    Each part of the pose names the sentence that it is taken from: GGA of any talker, or INGGA of one.
    """

    port: str
    """Serial device; "udp://0.0.0.0:10110", where datagrams come in; "socket://192.168.0.5:4001", a serial server."""
    baud: PositiveInt = 115200
    """Of a serial device."""
    sender: str | None = None
    """IP address that datagrams must come from; none: any."""
    place: str = "GGA"
    """GGA or RMC."""
    depth: str = "GGA"
    """GGA: its altitude above mean sea level; DPT, DBT, DBS, TS: depth below the surface."""
    attitude: str = "PASHR"
    """PASHR, PSXN (of kind 23, a Seapath's) or SA: roll and pitch. There is a pose for each."""
    heading: str = "PASHR"
    """PASHR, PSXN, HDT or SA."""
    velocity: str = "VTG"
    """VTG, RMC (nothing vertical), BS or BE (a Doppler log over ground)."""
    accuracy: str | None = None
    """GST; none: `nav.sigma.position_m` holds."""
    altitude: str | None = None
    """DPT or DBT (an echo sounder under the vehicle), or BD: altitude over the bottom; none: not told."""
    accept: dict[Literal["estimated", "manual", "simulated", "unsafe"], Annotated[NonNegative, unit("m")]] = (
        msgspec.field(default_factory=lambda: {"estimated": 10.0})
    )
    """Places and velocities that are used though no fix: GGA of quality 6, 7 and 8, RMC and VTG of mode E, M and S, and
    an RMC whose navigational status is U; each with what it adds to the standard deviation of the place, m. Estimated
    ones add nothing where `accuracy` names a sentence, which knows better. What is left out is refused, by name."""
    held: dict[str, HeldSettings] = msgspec.field(
        default_factory=lambda: {name: HeldSettings(max_age_s=1.5) for name in ("GGA", "RMC", "GST")}
    )
    """How long each sentence holds, by its name without talker; one left out: as its own defaults say."""

    @property
    def look_at(self) -> str:
        """What may be wrong of the line when what comes cannot be read; of a network that is less."""
        if udp_address(self.port):
            return "is nav.nmea.port right, and is what is sent there NMEA 0183?"
        server = "the serial server's " if tcp_address(self.port) else ""
        return f"are nav.nmea.port, {server}baud, ground and polarity right?"

    def __post_init__(self) -> None:
        udp_address(self.port) or tcp_address(self.port)
        for part, usable in NMEA_CHOICES.items():
            told = getattr(self, part)
            if told is not None and TALKER.sub("", told) not in usable:
                raise ValueError(f"{part}: {none_of(told, usable)}")
        if self.altitude is not None and TALKER.sub("", self.altitude) == TALKER.sub("", self.depth):
            raise ValueError(f"altitude: {self.altitude} tells the depth already")
        known = {name for usable in NMEA_CHOICES.values() for name in usable}
        unknown = self.held.keys() - known
        if unknown:
            raise ValueError(f"held: {none_of(min(unknown), sorted(known))}")


class NavSettings(Settings, frozen=True):
    """Where the vehicle's pose comes from."""

    source: Literal["canopen", "dbc", "nmea"] = "canopen"
    """How the INS speaks; the table of that name says more."""
    canopen: CanopenSettings | None = None
    """For source "canopen"."""
    dbc: DbcSettings | None = None
    """For source "dbc"."""
    nmea: NmeaSettings | None = None
    """For source "nmea"."""
    can: CanSettings = CanSettings()
    lever_arm_m: Lever = (0.0, 0.0, 0.0)
    """The point on the vehicle of which the INS tells place and velocity: forward, starboard and down of the body's
    origin, m."""
    stale_s: Seconds = 0.5
    """Time without a pose that is a problem, s."""
    clock_jump_s: Seconds = 0.1
    """A step of the INS's clock by more than this is taken at once, when four epochs in a row confirm it."""
    limits: LimitSettings = LimitSettings()
    sigma: SigmaSettings = SigmaSettings()

    def __post_init__(self) -> None:
        if getattr(self, self.source) is None:
            raise ValueError(f"{self.source}: missing, as source is {self.source!r}")


class NavConfig(Settings, frozen=True):
    """What the nav process reads of the configuration."""

    site: SiteSettings
    nav: NavSettings
