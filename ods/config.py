"""The configuration of the on-board processes: what `config/onboard.toml` may say."""

from pathlib import Path
from typing import Annotated

import msgspec

from ods.base.settings import Settings
from ods.nav_bridge.settings import NavSettings
from ods.pipeline.settings import PipelineSettings
from ods.runtime.supervisor import SuperviseSettings
from ods.sonar_link.settings import SonarSettings
from ods.tracker.settings import TrackerSettings


class BusSettings(Settings, frozen=True):
    """Where the processes meet."""

    run_dir: Path
    """Folder of sockets and locks; its path must stay under 80 characters."""

    def __post_init__(self) -> None:
        if len(str(self.run_dir)) > 80:
            raise ValueError(f"run_dir: {self.run_dir} is longer than 80 characters, too long for a socket path")


class SiteSettings(Settings, frozen=True):
    """The place: origin of the local north-east-down frame."""

    latitude_deg: Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)]
    longitude_deg: Annotated[float, msgspec.Meta(ge=-180.0, le=180.0)]


class OnboardConfig(Settings, frozen=True):
    """Everything the four on-board processes need."""

    bus: BusSettings
    site: SiteSettings
    sonar: SonarSettings
    pipeline: PipelineSettings
    tracker: TrackerSettings
    nav: NavSettings
    supervise: SuperviseSettings = SuperviseSettings()
