"""Settings of the `sonar_link` package."""

from typing import Annotated

import msgspec

from ods.settings import NonNegative, Positive, PositiveInt, Settings


class SonarSettings(Settings, frozen=True):
    """The line to the sonar and what is taken from it."""

    port: str
    """Serial device, such as "/dev/ttyUSB0", or a pyserial URL, such as "socket://192.168.0.5:7000"."""
    baud: PositiveInt = 12_000_000
    """Bits a second of the serial line."""
    latency_ms: NonNegative = 0.0
    """From the arrival of the last echo at the sonar to the first byte of its record on the line, ms."""
    max_record_bytes: Annotated[int, msgspec.Meta(ge=1024, le=64 * 1024 * 1024)] = 4 * 1024 * 1024
    """Longest record believed, bytes; a header that claims more is noise."""
    record_timeout_s: Positive = 1.0
    """A record that takes longer to arrive is given up, s; more than the longest one's time on the line. A false header
    holds pings up for so long at most."""
    reopen_min_s: Positive = 0.1
    """First pause before a lost port is tried again, s; it doubles with every failure."""
    reopen_max_s: Positive = 1.0
    """Longest such pause, s."""

    def __post_init__(self) -> None:
        if not self.port:
            raise ValueError("port: must name a device")
        if self.reopen_max_s < self.reopen_min_s:
            raise ValueError(f"reopen_max_s: {self.reopen_max_s:g} is less than reopen_min_s {self.reopen_min_s:g}")
