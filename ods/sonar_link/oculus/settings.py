"""Settings of an Oculus: the [sonar.oculus] table."""

from typing import Annotated, Literal

import msgspec

from ods.base.settings import Seconds, Settings, unit
from ods.sonar_link.oculus.messages import PING_RATES, SECOND_VERSION, STATUS_PORT, THIRTY_TWO_BIT, Fire, Flags

MODES = {"low": 1, "high": 2}


class OculusSettings(Settings, frozen=True):
    """The fire message, and the status port."""

    mode: Literal["low", "high"] = "low"
    """Low frequency: wider and farther."""
    range_m: Annotated[float, msgspec.Meta(ge=0.1, le=500.0)] = 40.0
    """The model may have a lower limit."""
    gain_percent: Annotated[float, msgspec.Meta(ge=0.0, le=100.0)] = 50.0
    gain_assist: bool = False
    """The sonar adapts its gain; levels then change from ping to ping."""
    gamma: Annotated[int, msgspec.Meta(ge=1, le=255)] = 127
    """Samples are amplitudes to the power gamma / 255: 127 gives weak echoes finer steps, 255 is linear."""
    sound_speed: Annotated[float, msgspec.Meta(ge=1300.0, le=1700.0), unit("m/s")] | None = None
    """m/s; left out: by temperature and salinity."""
    salinity_ppt: Annotated[float, msgspec.Meta(ge=0.0, le=50.0)] = 35.0
    """35: open sea; 0: fresh water."""
    ping_rate_hz: Literal[2, 5, 10, 15, 40] = 10
    """At most; a long range reduces it."""
    beams: Literal[256, 512] = 512
    sample_bits: Literal[8, 16, 32] = 8
    network_mbps: Annotated[int, msgspec.Meta(ge=1, le=255)] = 255
    """At most; 255: the link's."""
    message_version: Literal[1, 2] = 2
    """32 bits need 2, old firmware may know 1 only."""
    status_port: Annotated[int, msgspec.Meta(ge=0, le=65535)] = STATUS_PORT
    """UDP; 0: not received."""
    settle_s: Seconds = 10.0
    """Until settings appear in the pings."""

    def __post_init__(self) -> None:
        if self.sample_bits == 32 and self.message_version != SECOND_VERSION:
            raise ValueError("message_version: 32-bit samples need version 2")

    def fire(self) -> Fire:
        """Return the fire message."""
        flags = Flags.RANGE_IN_METRES | Flags.SIMPLE_RESULT
        flags |= Flags.BEAMS_512 if self.beams == 512 else Flags(0)
        flags |= Flags.SIXTEEN_BIT if self.sample_bits > 8 else Flags(0)
        flags |= Flags.GAIN_ASSIST if self.gain_assist else Flags(0)
        return Fire(
            mode=MODES[self.mode],
            ping_rate=PING_RATES[self.ping_rate_hz],
            network_speed=self.network_mbps,
            gamma=self.gamma,
            flags=int(flags),
            range_m=self.range_m,
            gain_percent=self.gain_percent,
            sound_speed=self.sound_speed or 0.0,
            salinity_ppt=self.salinity_ppt,
            extended_flags=THIRTY_TWO_BIT if self.sample_bits == 32 else 0,
        )
