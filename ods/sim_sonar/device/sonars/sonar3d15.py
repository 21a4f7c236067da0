"""A simulated Sonar 3D-15: range images of the scene, and pictures of signal strength, by multicast."""

import math

import numpy as np

from ods.sim_sonar.device.sonars import sonar3d15_packets as wire
from ods.sim_sonar.device.sonars.sonar3d15_packets import ImageSays
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.range_image import range_image, range_sonar
from ods.sim_sonar.sonar.model import SonarModel

SCALE_M = 15.0 / 2**14
STRENGTH = 120
"""Of every echo."""


class SimulatedSonar3d15:
    """The far end of a Sonar 3D-15: see `SimulatedSonar`. Nothing can be asked of it."""

    def __init__(self, nominal: ImageSimulator) -> None:
        """`nominal`: of the sonar's file, which gives openings, pixels, range and rate.

        Raises ValueError: a rough sea-bed, or a sonar without pixels.
        """
        self._nominal = nominal
        self._sonar = range_sonar(nominal.sonar)
        range_image(self._sonar, nominal.scene, 0.0, 0)

    @property
    def controls(self) -> object:
        """Nothing is asked for."""
        return None

    def listen(self, _device_ns: int) -> None:
        """It sends only."""

    def images(self) -> ImageSimulator:
        """Return those of the file."""
        return self._nominal

    def period_s(self, sonar: SonarModel) -> float:
        """Return the time from ping to ping."""
        return sonar.ping_period_s

    def telegram(self, images: ImageSimulator, t_s: float, number: int, _sent_ns: int, device_ns: int) -> list[bytes]:
        """Return the packets of the ping sent at scene time `t_s`, `device_ns` by the sonar's clock."""
        sonar = self._sonar
        ranges_m = range_image(sonar, images.scene, t_s, number)
        says = ImageSays(
            time_ns=device_ns,
            number=number,
            sound_speed=images.sonar.sound_speed,
            range_m=sonar.range_max_m,
            frequency_hz=round(images.sonar.frequency_hz),
            opening_deg=(2.0 * math.degrees(sonar.bearing_rad[-1]), 2.0 * math.degrees(sonar.elevation_rad[-1])),
            scale_m=SCALE_M,
        )
        strengths = np.where(ranges_m > 0.0, STRENGTH, 0).astype(np.uint8)
        return [wire.range_image(says, ranges_m), wire.strength_image(says, strengths)]

    def wanted(self, telegram: list[bytes]) -> list[bytes]:
        """Return all: it does not know who listens."""
        return telegram
