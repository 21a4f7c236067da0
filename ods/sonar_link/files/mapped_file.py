"""Opens a recording as mapped memory, with one-line errors."""

import mmap
from pathlib import Path

from ods.base.files.in_file import opened
from ods.sonar_link.files.ping_sequence import PingFileError


def memory_map(path: Path) -> mmap.mmap:
    """Return the whole file, read-only, without loading it. Raises PingFileError."""
    try:
        with opened(path) as file:
            return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except OSError as error:
        raise PingFileError(f"{path}: {error.strerror or error}") from error
    except ValueError as error:
        raise PingFileError(f"{path}: the file is empty") from error
