"""Settings of recorded sonar images: what `[recordings]` may say."""

from pathlib import Path

from ods.base.settings import Settings


class RecordingsSettings(Settings, frozen=True):
    """Decoders of recorded sonar images."""

    plugins: tuple[Path, ...] = ()
    """Python files or modules."""
