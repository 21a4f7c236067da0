"""The one error of recordings."""

from ods.base.errors import OdsError


class RecordingError(OdsError):
    """A recording cannot be written or read; the text is one line."""
