"""Settings that the process `listen` reads."""

from ods.base.settings import Settings
from ods.runtime.bus import BusSettings


class ListenConfig(Settings, frozen=True):
    """The tables that it reads."""

    bus: BusSettings
