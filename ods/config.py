"""The configuration of the on-board processes: what `config/onboard.toml` may say, and each process's part of it."""

from typing import TypeVar

from ods.base.frames.mounting import MountingSettings
from ods.base.geodesy import SiteSettings
from ods.base.settings import Settings
from ods.bridge.settings import BridgeSettings
from ods.nav_bridge.settings import NavSettings
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseSettings
from ods.recording.settings import RecordSettings
from ods.runtime.bus import BusSettings
from ods.runtime.supervisor import SuperviseSettings
from ods.sonar_link.files.settings import RecordingsSettings
from ods.sonar_link.settings import SonarSettings
from ods.tracker.settings import TrackerSettings

PartT = TypeVar("PartT", bound=Settings)


class OnboardConfig(Settings, frozen=True):
    """Everything the four on-board processes need."""

    bus: BusSettings
    site: SiteSettings
    sonar: SonarSettings
    nav: NavSettings
    pipeline: PipelineSettings = PipelineSettings()
    tracker: TrackerSettings = TrackerSettings()
    pose: PoseSettings = PoseSettings()
    supervise: SuperviseSettings = SuperviseSettings()
    recordings: RecordingsSettings = RecordingsSettings()
    record: RecordSettings = RecordSettings()
    bridge: BridgeSettings = BridgeSettings()

    def __post_init__(self) -> None:
        nmea, can = self.nav.nmea, self.nav.can
        own = ("nav.nmea.port", nmea.port) if self.nav.source == "nmea" and nmea else ("nav.can.channel", can.channel)
        if own[1] == self.sonar.port:
            raise ValueError(f"{own[0]}: {own[1]} is the sonar's (sonar.port)")

    @property
    def mounting(self) -> MountingSettings:
        """The sonar's, which pipeline and tracker read as well."""
        return self.sonar.mounting


def part_of(config: Settings, kind: type[PartT]) -> PartT:
    """Return the tables of a configuration that a worker reads: those of the same names as the fields of `kind`."""
    return kind(**{name: getattr(config, name) for name in kind.__struct_fields__})
