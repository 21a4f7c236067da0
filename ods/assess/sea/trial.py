"""Settings tried on every scene, and a scene's draws."""

from pathlib import Path
from typing import NamedTuple

from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.sonar.model import SonarModel
from ods.tracker.settings import TrackerSettings


class Trial(NamedTuple):
    """Settings to try on every scene."""

    sonar: SonarModel
    seconds: float
    clearance_m: float
    kept: Path | None
    """Folder of the images."""
    pipeline: PipelineSettings
    tracker: TrackerSettings
    knows_altitude: bool = True
    """The vehicle's pose reports it."""


class Draw(NamedTuple):
    """A scene, and which of its sea-beds and speckles."""

    name: str
    file: Path
    seed: int
