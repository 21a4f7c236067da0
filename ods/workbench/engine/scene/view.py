"""The image of an edited scene: what the sonar sends, and what would be expected of it, with and without its errors."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32
from ods.base.clock import NS
from ods.base.errors import OdsError
from ods.base.frames import geometry
from ods.messages import Ping, TruthObject
from ods.sim_sonar.pose import VehiclePose
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sonar.model import SonarModel
from ods.workbench.engine.scene.curves import Curve
from ods.workbench.engine.scene.plan import Plan

PROFILE_POINTS = 500


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
    head: VehiclePose
    """Of the sonar."""
    plan: Plan

    @property
    def fan_db(self) -> Floats32:
        """As it is sent: (beams of one plane, samples), of several planes the highest, dB over the median."""
        level = self.level_db.reshape(self.sonar.planes, -1, self.ping.samples).max(axis=0)
        return np.asarray(level - np.median(level))

    def profile(self, beam: int) -> list[Curve]:
        """Return one beam's levels over range, m, figure 10 of [SSIE]: sent, expected, expected of a perfect sonar."""
        near, step = self.sonar.range0_m, self.sonar.dr_m
        starts = (self.ping.range0_m, near, near)
        rows = (each[beam] for each in (self.level_db, self.expected_db, self.perfect_db))
        return [_pooled(start, step, row) for start, row in zip(starts, rows, strict=True)]

    def truth_circles(self) -> list[tuple[float, float, float]]:
        """Return range, bearing and radius of the objects in the fan."""
        shown = [item for item in self.truth if item.in_sector]
        places = np.array([item.position_ned for item in shown]).reshape(-1, 3)
        distance, bearing, _ = geometry.body_to_polar(geometry.global_to_body(places, *self.head))
        radii = [item.radius_m for item in shown]
        return list(zip(distance.tolist(), bearing.tolist(), radii, strict=True))

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


def pictured(_: Callable[[float], bool], asked: Asked) -> Pictured:
    """Return one ping of a scene; in the process where this is called, what did not change is not made again.

    Raises OdsError, one line.
    """
    from ods.workbench.engine.scene.pictures import pictures  # the simulator: not in the page's process

    return pictures().picture(asked)


def _pooled(start_m: float, step_m: float, level_db: Floats32) -> Curve:
    """Return a curve of at most PROFILE_POINTS points, each the highest of its neighbours."""
    window = -(-len(level_db) // PROFILE_POINTS)
    padded = np.pad(level_db, (0, -len(level_db) % window), constant_values=-np.inf)
    points: Floats = padded.astype(np.float64).reshape(-1, window).max(axis=1)
    first = start_m + step_m * 0.5 * (window - 1)
    return Curve(np.asarray(first + step_m * window * np.arange(len(points))), points)
