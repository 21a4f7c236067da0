"""The image of an edited scene: what the sonar sends, and what would be expected of it, with and without its errors."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.messages import Ping, TruthObject
from ods.plots.polar import level_db
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.pose import Transmission
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.receiver.signal_chain import Receiver
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.shots import shot_at
from ods.sim_sonar.sonar.model import SonarModel
from ods.workbench.model.scene_effects import perfect

FAINTEST = 1e-3
"""Amplitude, counts, that stands for silence."""


class SceneError(OdsError):
    """A scene that cannot be; the text is one line."""


class Asked(NamedTuple):
    """What is to be seen."""

    file: SceneFile
    sonar: str
    ping: int
    beside: Path | None = None
    """The scene's file: beside its folder may be one of sonars."""


class Pictured(NamedTuple):
    """One ping of a scene."""

    asked: Asked
    sonar: SonarModel
    ping: Ping
    truth: list[TruthObject]
    level_db: Floats32
    """(beams, samples) as it is sent, dB over one count."""
    expected_db: Floats32
    """The same without speckle: root mean square, with what is wrong with sonar and water."""
    perfect_db: Floats32
    """The same with nothing wrong."""

    @property
    def t_s(self) -> float:
        """Scene time, s."""
        return self.ping.t_ns / NS


def built(file: SceneFile) -> Scene:
    """Return a scene. Raises SceneError for one that cannot be."""
    try:
        return Scene(file)
    except (ValueError, OSError) as error:
        raise SceneError(" ".join(str(error).split())) from error


def pings_of(file: SceneFile, sonar: SonarModel) -> int:
    """Return how many pings a whole scene has."""
    return int(file.duration_s / sonar.ping_period_s) + 1


class ScenePictures:
    """Makes images of one scene after the other; for use by one thread. What did not change is not made anew."""

    def __init__(self) -> None:
        self._sonar: tuple[tuple[str, Path | None], SonarModel] | None = None
        self._images: ImageSimulator | None = None
        self._perfect: tuple[ImageLevels, Receiver] | None = None

    def picture(self, asked: Asked) -> Pictured:
        """Return one ping; after the last one of the scene its last. Raises OdsError, one line."""
        sonar = self._sonar_of(asked)
        number = min(asked.ping, pings_of(asked.file, sonar) - 1)
        try:
            images = self._images = self._seeing(asked.file, sonar)
            shot = shot_at(images, number)
            t_s = shot.ping.t_ns / NS
            ideal = self._perfect_receiver(asked.file, sonar)
        except ValueError as error:  # levels that do not fit the sonar
            raise SceneError(str(error)) from error
        sent = Transmission(images.scene.head_at(t_s), t_s, number)
        expected = ideal.mean_image(images.mean_area(t_s), ideal.levels_of(sent))
        return Pictured(
            asked, sonar, shot.ping, list(shot.truth.objects), level_db(shot.ping),
            _decibels(images.mean_image(t_s, number)), _decibels(expected),
        )  # fmt: skip

    def _sonar_of(self, asked: Asked) -> SonarModel:
        key = asked.sonar, asked.beside
        if self._sonar is None or self._sonar[0] != key:
            self._sonar, self._images, self._perfect = (key, find_sonar(asked.sonar, asked.beside)), None, None
        return self._sonar[1]

    def _seeing(self, file: SceneFile, sonar: SonarModel) -> ImageSimulator:
        """Return a simulator; its tables, which take a quarter of a second, are made anew for other levels only."""
        known = self._images
        if known is None or (known.scene.file.image, known.scene.file.seed) != (file.image, file.seed):
            return ImageSimulator(sonar, built(file))
        return known if known.scene.file == file else known.seeing(built(file))

    def _perfect_receiver(self, file: SceneFile, sonar: SonarModel) -> Receiver:
        levels = perfect(file).image
        if self._perfect is None or self._perfect[0] != levels:
            self._perfect = levels, Receiver(sonar, levels, file.seed)
        return self._perfect[1]


def _decibels(image: Image) -> Floats32:
    return np.asarray(20.0 * np.log10(np.maximum(image, FAINTEST)), np.float32)
