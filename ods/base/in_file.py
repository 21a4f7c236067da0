"""Files that a command reads: missed before anything slow is imported, not after."""

import os
from pathlib import Path

from ods.base.errors import OdsError


def refuse_missing(*paths: Path | None) -> None:
    """Raise OdsError, one line, for the first file or folder that is not there; None is one that was not named."""
    for path in filter(None, paths):
        try:
            path.stat()
        except OSError as error:
            raise OdsError(f"{path}: {os.strerror(error.errno or 0)}") from error
