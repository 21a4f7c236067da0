"""Settings of the `tracker` package."""

from ods.settings import Settings


class TrackerSettings(Settings, frozen=True):
    """Foundation stub, filled in with the package."""
