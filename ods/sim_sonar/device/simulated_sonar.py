"""Protocol and requested settings of a simulated sonar."""

from typing import Protocol

from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.sonar.model import SonarModel


class SimulatedSonar(Protocol):
    """A simulated sonar's messages. Requested settings apply from the next ping."""

    @property
    def controls(self) -> object:
        """The requested settings; new images are made when they change."""

    def listen(self, device_ns: int) -> None:
        """Read and answer requests, announce itself; `device_ns`: UTC by the sonar's clock. Called once a ping."""

    def images(self) -> ImageSimulator:
        """Return an image simulator with the requested settings and new tables (about 50 ms)."""

    def period_s(self, sonar: SonarModel) -> float:
        """Return the time from ping to ping."""

    def telegram(self, images: ImageSimulator, t_s: float, number: int, sent_ns: int, device_ns: int) -> list[bytes]:
        """Return the records of the ping sent at scene time `t_s`, `sent_ns` on CLOCK_MONOTONIC."""

    def wanted(self, telegram: list[bytes]) -> list[bytes]:
        """Return those records that go out now."""
