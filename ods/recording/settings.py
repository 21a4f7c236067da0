"""Settings of the `recording` package."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from ods.base.settings import NonNegative, Settings
from ods.tracker.settings import TrackerSettings


class RecordSettings(Settings, frozen=True):
    """Records everything on the bus."""

    on: bool = False
    """Record, by `ods run` or systemd."""
    folder: Path | None = None
    """Each mission gets a folder inside."""
    segment_min: Annotated[float, msgspec.Meta(ge=0.1, le=60.0)] = 10.0
    """Duration of a file, whose index is kept in memory."""
    when_full: Literal["wait", "delete_oldest", "stop"] = "wait"
    """`wait`, `stop`, or `delete_oldest`: the oldest complete file in `folder`."""
    keep_free_mb: NonNegative = 100.0
    """With less free space the disk counts as full, to leave room for the map."""
    queue_mb: Annotated[float, msgspec.Meta(ge=1.0, le=1000.0)] = 32.0
    """Memory for messages waiting for the disk; beyond it the oldest are dropped and counted."""

    def __post_init__(self) -> None:
        if self.on and self.folder is None:
            raise ValueError("folder: missing, and `on` is true")


class RecordConfig(Settings, frozen=True):
    """Configuration of the record process."""

    record: RecordSettings
    tracker: TrackerSettings = TrackerSettings()
    """For the map at the start."""
    text: str = ""
    """The configuration itself, which is recorded too."""
    out: Path | None = None
    """Folder for this recording alone, instead of one in `record.folder`."""
    seconds: float | None = None
    """End by itself after this time."""
