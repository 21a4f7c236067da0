"""Settings of the `nav_bridge` package."""

from ods.settings import Settings


class NavSettings(Settings, frozen=True):
    """Foundation stub, filled in with the package."""
