"""Makes the images of edited scenes, in a process of its own: the simulator and scipy take 40 MB."""

from functools import cache
from pathlib import Path

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.base.clock import NS
from ods.plots.polar import level_db
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.image import ImageSimulator
from ods.sim_sonar.pose import Transmission
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.receiver.signal_chain import Receiver
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.shots import shot_at
from ods.sim_sonar.sonar.model import SonarModel
from ods.workbench.engine.scene.plan import plan_of
from ods.workbench.engine.scene.view import Asked, Pictured, SceneError, built, pings_of
from ods.workbench.model.scene.effects import perfect

FAINTEST = 1e-3
"""Amplitude, counts, that stands for silence."""


@cache
def pictures() -> "ScenePictures":
    """Return those of this process."""
    return ScenePictures()


class ScenePictures:
    """Makes images of one scene after the other; for use by one thread. What did not change is not made again."""

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
        head = images.scene.head_at(t_s)
        sent = Transmission(head, t_s, number)
        expected = ideal.mean_image(images.mean_area(t_s), ideal.levels_of(sent))
        return Pictured(
            asked, sonar, shot.ping, list(shot.truth.objects), level_db(shot.ping),
            _decibels(images.mean_image(t_s, number)), _decibels(expected), head,
            plan_of(images.scene, sonar, t_s),
        )  # fmt: skip

    def _sonar_of(self, asked: Asked) -> SonarModel:
        key = asked.sonar, asked.beside
        if self._sonar is None or self._sonar[0] != key:
            self._sonar, self._images, self._perfect = (key, find_sonar(asked.sonar, asked.beside)), None, None
        return self._sonar[1]

    def _seeing(self, file: SceneFile, sonar: SonarModel) -> ImageSimulator:
        """Return a simulator; its tables, which take a quarter of a second, are made again for other levels only."""
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
