"""Settings of the `pipeline` package."""

from ods.settings import Settings


class PipelineSettings(Settings, frozen=True):
    """Foundation stub, filled in with the package."""
