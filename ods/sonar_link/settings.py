"""Settings of the `sonar_link` package."""

from pathlib import Path
from typing import Annotated

import msgspec

from ods.base.frames.mounting import MountingSettings
from ods.base.settings import NonNegativeSeconds, Seconds, Settings, slider
from ods.messages import SonarLevel, SonarRange
from ods.runtime.port.address import transport_of
from ods.sonar_link.norbit.settings import NorbitSettings
from ods.sonar_link.oculus.settings import OculusSettings
from ods.sonar_link.ping360.settings import Ping360Settings
from ods.sonar_link.registry import PLUGINS, PROTOCOLS, unsupported_reason
from ods.sonar_link.s7k.settings import S7kSettings
from ods.sonar_link.sonar3d15.settings import Sonar3d15Settings


class SonarSettings(Settings, frozen=True):
    """The connection to the sonar."""

    port: str
    """Serial device; "tcp://192.168.0.5:7000", the sonar itself (s7k: network frames); "socket://192.168.0.5:4001", a
    serial server; "udp://192.168.2.2:9092", a datagram bridge; "udp://224.0.0.96:4747", a multicast group."""
    protocol: str = "s7k"
    """Name in docs/sonars/README.md, or of a plug-in."""
    plugins: tuple[Path, ...] = ()
    """Python files or modules."""
    baud: Annotated[int, msgspec.Meta(ge=300, le=100_000_000)] = 12_000_000
    """bit/s."""
    publish_raw: bool = False
    """Publish the received bytes for the recorder."""
    latency_ms: Annotated[float, msgspec.Meta(ge=-200.0, le=60_000.0), slider(-50.0, 1000.0, unit="ms")] = 0.0
    """From the last echo's arrival to its record's first byte. Below 0 only to compensate for a later INS."""
    max_record_bytes: Annotated[int, msgspec.Meta(ge=1024, le=64 * 1024 * 1024)] = 4 * 1024 * 1024
    """A header with a larger size is treated as noise."""
    record_timeout_s: Seconds = 1.0
    """Slower records are dropped: set it longer than any record takes; a false header delays pings by up to this
    time."""
    reopen_min_s: Seconds = 0.1
    """Pause before a lost port is reopened; doubled with every failure."""
    reopen_max_s: Seconds = 1.0
    """Longest such pause."""
    silence_s: NonNegativeSeconds = 5.0
    """A TCP or UDP peer silent for this long is connected again; 0: never."""
    range_m: SonarRange | None = None
    """Left out: unchanged."""
    power_db: SonarLevel | None = None
    """Likewise; dB re 1 uPa at 1 m."""
    gain_db: SonarLevel | None = None
    """Likewise."""
    control_repeat_s: Seconds = 1.0
    """A setting that has no effect is sent again after this time."""
    control_attempts: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 3
    """Attempts before a setting counts as not accepted."""
    mounting: MountingSettings = MountingSettings()
    s7k: S7kSettings = S7kSettings()
    oculus: OculusSettings = OculusSettings()
    norbit: NorbitSettings = NorbitSettings()
    ping360: Ping360Settings = Ping360Settings()
    sonar3d15: Sonar3d15Settings = Sonar3d15Settings()

    @property
    def control_patience_s(self) -> float:
        """How long a planner waits for its request to take effect, s."""
        return self.control_repeat_s * (self.control_attempts + 1)

    def __post_init__(self) -> None:
        if not self.port:
            raise ValueError("port: must be a device or an address")
        if self.protocol not in PROTOCOLS and PLUGINS.may_add(self.plugins):
            transport_of(self.port)  # the rest is checked when they are loaded
        elif wrong := unsupported_reason(self):
            raise ValueError(wrong)
        if self.reopen_max_s < self.reopen_min_s:
            raise ValueError(f"reopen_max_s: {self.reopen_max_s:g} is less than reopen_min_s {self.reopen_min_s:g}")


class SonarConfig(Settings, frozen=True):
    """The part of the configuration that the sonar process reads."""

    sonar: SonarSettings
