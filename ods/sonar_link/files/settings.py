"""Settings of recorded sonar images: what `[recordings]` may say."""

from pathlib import Path

from ods.base.settings import Settings


class RecordingsSettings(Settings, frozen=True):
    """Recorded sonar images."""

    plugins: tuple[Path, ...] = ()
    """Python files, or modules, with decoders."""
