"""The errors of recordings."""

from typing import ClassVar

from ods.base.errors import OdsError


class RecordingError(OdsError):
    """A recording cannot be written or read; the text is one line."""


class UnreadableError(RecordingError):
    """There is no recording, or none that can be read: as a failed check, no error in how the command was called."""

    exit_code: ClassVar[int] = 1
