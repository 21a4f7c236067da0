"""The simulated SeaBat: s7k records, and remote control of range, power and gain."""

import dataclasses
from pathlib import Path

from ods.base.errors import OdsError
from ods.sim_sonar.device.remote_control_server import NOMINAL_GAIN_DB, NOMINAL_POWER_DB, Line, RemoteControlServer
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.model import SonarModel
from ods.sonar_link.s7k import records


def refuse_beyond_s7k(scene_file: Path, scene: Scene, sonar_file: Path | str, sonar: SonarModel) -> None:
    """Raise OdsError, with file and key, for what no record of s7k can carry."""
    if scene.file.image.samples == "linear8":
        raise OdsError(f"{scene_file}: image.samples: s7k has no record for linear8")
    try:
        records.first_sample_of(sonar.range0_m, sonar.dr_m)
    except ValueError as error:
        raise OdsError(f"{sonar_file}: {error}") from error


class SimulatedSeaBat:
    """The far end of a 7k sonar: see `SimulatedSonar`."""

    def __init__(self, nominal: ImageSimulator, line: Line) -> None:
        """`nominal`: the images of the longest range, at the scene's levels: those after switching on."""
        self._nominal = nominal
        self._remote = RemoteControlServer(nominal.sonar, line)

    @property
    def controls(self) -> object:
        """Range, power and gain."""
        return self._remote.controls

    def listen(self, device_ns: int) -> None:
        """Obey what has come; the replies are stamped `device_ns`."""
        self._remote.listen(device_ns)

    def images(self) -> ImageSimulator:
        """Return images of as many samples as reach the range."""
        asked, sonar = self._remote.controls, self._nominal.sonar
        samples = 1 + round((asked.range_m - sonar.range0_m) / sonar.dr_m)
        return ImageSimulator(
            dataclasses.replace(sonar, samples=min(max(samples, 1), sonar.samples)),
            self._nominal.scene,
            power_db=asked.power_db - NOMINAL_POWER_DB,
            gain_db=asked.gain_db - NOMINAL_GAIN_DB,
        )

    def period_s(self, sonar: SonarModel) -> float:
        """Return the time from ping to ping, which follows from the range."""
        return sonar.ping_period_s

    def telegram(self, images: ImageSimulator, t_s: float, number: int, sent_ns: int, device_ns: int) -> list[bytes]:
        """Return the records of a ping."""
        return records.ping_records(images.ping(t_s, number, sent_ns, device_ns), controls=self._remote.controls)

    def wanted(self, telegram: list[bytes]) -> list[bytes]:
        """Return all on a serial line, over TCP those subscribed to."""
        return self._remote.wanted(telegram)
