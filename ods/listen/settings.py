"""What the process `listen` reads of the configuration."""

from ods.base.settings import Settings
from ods.runtime.bus import BusSettings


class ListenConfig(Settings, frozen=True):
    """The tables that it reads."""

    bus: BusSettings
