"""Settings of the `sonar_link` package."""

from ods.settings import Settings


class SonarSettings(Settings, frozen=True):
    """Foundation stub, filled in with the package."""
