"""Settings of the sim process, from config/bench.toml."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from ods.base.settings import NonNegative, Positive, Settings
from ods.runtime.bus import BusSettings

INS_STEP_M = (40.0, -25.0, 0.0)
"""North, east, down."""
Speed = Annotated[float, msgspec.Meta(ge=-10.0, le=10.0)]
Blindness = Literal["zeros", "dead_beams", "cut_beams", "head_blocked", "saturated"]


class FaultSettings(Settings, frozen=True):
    """A fault on the simulated side."""

    kind: Literal["serial_unplugged", "sonar_silent", "sonar_garbage", "ins_silent", "ins_steps", "loud"] | Blindness
    """serial_unplugged: the sonar's line disappears; sonar_silent, ins_silent: the device sends nothing; sonar_garbage:
    it sends random bytes; ins_steps: the INS's position is off by 47 m. Image samples: zeros: all are 0; dead_beams:
    the port half is 0; cut_beams: the far half is 0; head_blocked: 20 dB weaker; saturated: at full scale; loud: with
    noise 20 dB over the median."""
    at_s: NonNegative
    """Mission time."""
    for_s: Positive


class VehicleSettings(Settings, frozen=True):
    """What the vehicle can do."""

    least_m_s: NonNegative = 1.0
    """Slower, it does not steer."""
    most_m_s: Positive = 3.0
    acceleration_m_s2: Positive = 0.2
    """Along its course."""
    turn_rate_deg_s: Positive = 10.0
    turn_acceleration_deg_s2: Positive = 10.0
    climb_m_s: Positive = 0.5
    """Up and down."""
    radius_m: Annotated[float, msgspec.Meta(ge=0.0, le=20.0)] = 0.5
    """Of the circle that must not touch anything."""


class SteeredVehicleSettings(Settings, frozen=True):
    """A vehicle that follows set points on CAN, starting as in the scene."""

    eds: Path
    """Of its CANopen node (RPDO 1)."""
    node_id: Annotated[int, msgspec.Meta(ge=1, le=127)] = 6
    current_m_s: tuple[Speed, Speed] = (0.0, 0.0)
    """North, east."""
    can_do: VehicleSettings = VehicleSettings()


class SimSettings(Settings, frozen=True):
    """The simulated devices."""

    scene: Path
    sonar: Path
    ins: Literal["canopen", "dbc", "nmea"] = "canopen"
    """nav.source on board must be the same."""
    ins_eds: Path | None = None
    """Of "canopen"."""
    ins_dbc: Path | None = None
    """Of "dbc", with the messages of config/sbg.dbc."""
    can: Literal["auto", "vcan0", "slcan"] = "auto"
    """auto: vcan0 if the kernel has it, otherwise slcan."""
    sonar_line: Literal["serial", "tcp", "oculus", "norbit", "ping360", "ping360_udp", "sonar3d15"] = "serial"
    """serial: s7k on a pseudo-terminal; tcp: the same in network frames, for one client; oculus, norbit: by TCP;
    ping360, ping360_udp: a Ping360 on a pseudo-terminal, or behind a bridge; sonar3d15: by multicast. Networks at
    127.0.0.1."""
    sonar_tcp_port: Annotated[int, msgspec.Meta(ge=1, le=65535)] = 7000
    """Unless serial."""
    sonar_status_port: Annotated[int, msgspec.Meta(ge=1, le=65535)] = 52102
    """UDP, an Oculus's."""
    sonar_command_port: Annotated[int, msgspec.Meta(ge=1, le=65535)] = 2209
    """TCP, a Norbit's."""
    sonar_udp_port: Annotated[int, msgspec.Meta(ge=1, le=65535)] = 9092
    """Of ping360_udp's bridge, or sonar3d15's multicast group."""
    boot_s: NonNegative = 2.0
    """Before the first ping."""
    sonar_latency_ms: NonNegative = 2.0
    """From the last echo to the first byte; the bench sets it on board, too."""
    pose_rate_hz: Positive = 100.0
    vehicle: SteeredVehicleSettings | None = None
    """None: the vehicle moves as in the scene."""
    sonar_clock_offset_s: float = 0.25
    """Clock minus UTC."""
    ins_clock_offset_s: float = -0.125
    """Clock minus UTC."""
    fault: list[FaultSettings] = msgspec.field(default_factory=list)

    def __post_init__(self) -> None:
        files = {"canopen": ("ins_eds", self.ins_eds), "dbc": ("ins_dbc", self.ins_dbc)}
        key, file = files.get(self.ins, ("", Path()))
        if file is None:
            raise ValueError(f"{key}: missing, as ins is {self.ins!r}")


class SimConfig(Settings, frozen=True):
    """Everything the sim process needs."""

    bus: BusSettings
    onboard: Path
    """The configuration under test; the bench replaces its ports and folders by those of the simulation."""
    sim: SimSettings
