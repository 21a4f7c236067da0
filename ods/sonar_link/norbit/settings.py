"""Settings of a Norbit: the [sonar.norbit] table."""

from typing import Annotated, Literal

import msgspec

from ods.base.settings import Settings, unit
from ods.sonar_link.norbit.control import Command
from ods.sonar_link.norbit.packets import COMMAND_PORT, FORWARD

LONGEST_RANGE_M = 600.0
PROBE = -1.0
"""Sound speed that stands for the probe at the sonar."""


class NorbitSettings(Settings, frozen=True):
    """Commands sent after each connection."""

    command_port: Annotated[int, msgspec.Meta(ge=0, le=65535)] = COMMAND_PORT
    """TCP; 0: no commands, another program sets the sonar."""
    range_m: Annotated[float, msgspec.Meta(ge=1.0, le=LONGEST_RANGE_M)] = 40.0
    opening_deg: Annotated[float, msgspec.Meta(ge=1.0, le=360.0)] = 140.0
    """Of the fan."""
    beams: Literal[64, 128, 256, 512] = 512
    samples: Annotated[int, msgspec.Meta(ge=64, le=2048)] = 1000
    """Per beam, about: the sonar sends every n-th of its own, 1 cm apart."""
    frequency_khz: Annotated[float, msgspec.Meta(ge=80.0, le=1000.0), unit("kHz")] = 400.0
    """Carrier."""
    bandwidth_khz: Annotated[float, msgspec.Meta(ge=0.0, le=80.0), unit("kHz")] = 80.0
    """Of the chirp."""
    amplitude: Annotated[int, msgspec.Meta(ge=0, le=15)] = 15
    """Transmitted amplitude, in the sonar's own steps; 0: none."""
    pulse_us: Annotated[float, msgspec.Meta(ge=10.0, le=819.0), unit("us")] = 500.0
    """Of the chirp."""
    gain_ramp_db: Annotated[float, msgspec.Meta(ge=0.0, le=100.0), unit("dB")] = 50.0
    """dB per 100 m; 0: `gain_db` at all ranges."""
    gain_db: Annotated[float, msgspec.Meta(ge=0.0, le=100.0), unit("dB")] = 0.0
    """If `gain_ramp_db` is 0."""
    ping_rate_hz: Annotated[float, msgspec.Meta(ge=0.1, le=60.0)] = 10.0
    """At most; a long range reduces it."""
    sound_speed: Annotated[float, msgspec.Meta(ge=1300.0, le=1700.0), unit("m/s")] | Literal["probe"] | None = None
    """m/s; "probe": the sonar's probe; left out: unchanged."""

    def commands(self) -> list[Command]:
        """Return the commands in the order of sending; pinging last."""
        speed = PROBE if self.sound_speed == "probe" else self.sound_speed
        sound = [] if speed is None else [Command("sound_velocity", (float(speed),))]
        return [
            Command("set_mode", (FORWARD,)),
            Command("set_flip", (0,)),
            Command("set_gate_mode", (0,)),
            Command("set_range", (0.0, self.range_m)),
            Command("set_direction", (0.0,)),
            Command("set_opening_angle", (self.opening_deg,)),
            Command("set_resolution", (self.samples, self.beams)),
            Command("set_tx", (self.frequency_khz, self.bandwidth_khz, self.amplitude, self.pulse_us)),
            Command("set_vga", (self.gain_ramp_db,)),
            *([Command("set_gain", (self.gain_db,))] if not self.gain_ramp_db else []),
            *sound,
            Command("set_trigger_mode", (2,)),
            Command("set_rate", (self.ping_rate_hz,)),
            Command("set_tp_rate", (self.ping_rate_hz,)),
            Command("set_power", (1,)),
        ]
