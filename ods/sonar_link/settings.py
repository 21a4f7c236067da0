"""Settings of the `sonar_link` package."""

from pathlib import Path
from typing import Annotated

import msgspec

from ods.base.mounting import MountingSettings
from ods.base.settings import NonNegativeSeconds, Seconds, Settings, slider
from ods.messages import SonarLevel, SonarRange
from ods.runtime.port.address import transport_of
from ods.sonar_link.norbit.settings import NorbitSettings
from ods.sonar_link.oculus.settings import OculusSettings
from ods.sonar_link.ping360.settings import Ping360Settings
from ods.sonar_link.registry import PLUGINS, PROTOCOLS, objection
from ods.sonar_link.s7k.settings import S7kSettings


class SonarSettings(Settings, frozen=True):
    """The line to the sonar, what is taken from it, and what the sonar is told to do."""

    port: str
    """Serial device, such as "/dev/ttyUSB0"; or "tcp://192.168.0.5:7000", a sonar on the network (s7k: in
    network frames); or "socket://192.168.0.5:4001", a serial server with the bare bytes of the line; or
    "udp://192.168.2.2:9092", a bridge that takes and sends datagrams."""
    protocol: str = "s7k"
    """What the sonar speaks: a name of the table in docs/sonar-link.md, or of a plug-in."""
    plugins: tuple[Path, ...] = ()
    """Python files, or modules by name, that register protocols of the user's own."""
    baud: Annotated[int, msgspec.Meta(ge=300, le=100_000_000)] = 12_000_000
    """Bits a second of the serial line."""
    publish_raw: bool = False
    """Publish the bytes of the line, too, on the topic `raw`, for the recorder."""
    latency_ms: Annotated[float, msgspec.Meta(ge=-200.0, le=60_000.0), slider(-50.0, 1000.0, unit="ms")] = 0.0
    """From the arrival of the last echo at the sonar to the first byte of its record on the line, ms. Below 0 only to
    even out an INS that is later than the sonar."""
    max_record_bytes: Annotated[int, msgspec.Meta(ge=1024, le=64 * 1024 * 1024)] = 4 * 1024 * 1024
    """Longest record believed, bytes; a header that claims more is noise."""
    record_timeout_s: Seconds = 1.0
    """A record that takes longer to arrive is given up, s; more than the longest one's time on the line. A false header
    holds pings up for so long at most."""
    reopen_min_s: Seconds = 0.1
    """First pause before a lost port is tried again, s; it doubles with every failure."""
    reopen_max_s: Seconds = 1.0
    """Longest such pause, s."""
    silence_s: NonNegativeSeconds = 5.0
    """A TCP connection, or a UDP peer, without a byte for so long is given up and begun anew, s; 0: never. Serial lines
    stay open."""
    range_m: SonarRange | None = None
    """Range that the sonar is set to after each connection, m; left out: as the sonar is."""
    power_db: SonarLevel | None = None
    """Transmit power likewise, dB re 1 uPa at 1 m."""
    gain_db: SonarLevel | None = None
    """Receiver gain likewise, dB."""
    control_repeat_s: Seconds = 1.0
    """Time for a setting to show in the sonar's record 7000 before it is sent again, s."""
    control_attempts: Annotated[int, msgspec.Meta(ge=1, le=1000)] = 3
    """How often a setting is sent before it counts as not taken."""
    mounting: MountingSettings = MountingSettings()
    s7k: S7kSettings = S7kSettings()
    oculus: OculusSettings = OculusSettings()
    norbit: NorbitSettings = NorbitSettings()
    ping360: Ping360Settings = Ping360Settings()

    @property
    def control_patience_s(self) -> float:
        """How long a planner waits for its request to take effect, s."""
        return self.control_repeat_s * (self.control_attempts + 1)

    def __post_init__(self) -> None:
        if not self.port:
            raise ValueError("port: must name a device")
        if self.protocol not in PROTOCOLS and PLUGINS.may_add(self.plugins):
            transport_of(self.port)  # the rest is checked when they are loaded
        elif wrong := objection(self):
            raise ValueError(wrong)
        if self.reopen_max_s < self.reopen_min_s:
            raise ValueError(f"reopen_max_s: {self.reopen_max_s:g} is less than reopen_min_s {self.reopen_min_s:g}")


class SonarConfig(Settings, frozen=True):
    """What the sonar process reads of the configuration."""

    sonar: SonarSettings
