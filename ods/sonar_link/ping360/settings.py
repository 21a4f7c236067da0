"""Settings of a Ping360: the [sonar.ping360] table."""

import math
from typing import Annotated, Literal

import msgspec

from ods.base.settings import Settings, unit
from ods.sonar_link.ping360.messages import TICK_S, TURN, Sweep, Transmission

GAINS = {"low": 0, "normal": 1, "high": 2}
LEAST_PERIOD, MOST_PERIOD = 80, 40000
"""Of samples, `TICK_S` each."""
PULSE_SAMPLES = 64
"""Longest pulse that the firmware allows, samples."""


class Ping360Settings(Settings, frozen=True):
    """Set after each connection. Bearings are from the sonar's mark."""

    range_m: Annotated[float, msgspec.Meta(ge=1.0, le=60.0)] = 50.0
    """With a shorter range the head turns faster."""
    sector_deg: Annotated[float, msgspec.Meta(ge=20.0, le=360.0)] = 120.0
    """Centred on the mark; 90 degrees take 1.5 to 9 s, depending on the range."""
    steps: Annotated[int, msgspec.Meta(ge=1, le=10)] = 1
    """Motor steps of 0.9 degrees between beams 2 degrees wide."""
    samples: Annotated[int, msgspec.Meta(ge=200, le=1200)] = 1200
    """Most per beam."""
    gain: Literal["low", "normal", "high"] = "normal"
    frequency_khz: Annotated[int, msgspec.Meta(ge=650, le=850), unit("kHz")] = 750
    """Carrier."""
    pulse_us: Annotated[int, msgspec.Meta(ge=0, le=1000), unit("us")] = 0
    """0: chosen by the range, as in the maker's viewer."""
    delay_ms: Annotated[int, msgspec.Meta(ge=0, le=100), unit("ms")] = 0
    """Between beams, for a slow line."""
    sound_speed: Annotated[float, msgspec.Meta(ge=1400.0, le=1600.0), unit("m/s")] = 1500.0
    """m/s; the sonar measures none."""
    ping_s: Annotated[float, msgspec.Meta(ge=0.2, le=2.0), unit("s")] = 0.8
    """Beams of this duration make one ping."""

    @property
    def sweep(self) -> Sweep:
        """The sector in gradians; of a whole turn, all beams once."""
        if self.sector_deg >= 360.0:
            return Sweep(TURN // 2, TURN // 2 - 1, self.steps, self.delay_ms)
        half = self.steps * round(self.sector_deg / 360.0 * TURN / 2 / self.steps)
        return Sweep(TURN - half, half, self.steps, self.delay_ms)

    @property
    def transmission(self) -> Transmission:
        """Settings requested for each beam."""
        ticks = 2.0 * self.range_m / self.sound_speed / TICK_S
        samples = max(1, min(self.samples, math.floor(ticks / LEAST_PERIOD)))
        period = min(max(round(ticks / samples), LEAST_PERIOD), MOST_PERIOD)
        sample_us = 1e6 * period * TICK_S
        by_range = max(1.25 * sample_us, 4000.0 * self.range_m / self.sound_speed)
        pulse_us = self.pulse_us or max(5, min(round(by_range), math.floor(PULSE_SAMPLES * sample_us), 500))
        return Transmission(GAINS[self.gain], pulse_us, period, self.frequency_khz, samples)
