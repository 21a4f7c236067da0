"""Files that are read, which may come from anywhere: what is no file is not waited for, and bounds of all readers.

Readers of each format look at what a file would unpack to before they unpack it, and refuse in one line of their own.
"""

import errno
import os
import stat
from pathlib import Path
from typing import BinaryIO

from ods.base.errors import OdsError, UnfitFileError

MOST_BYTES = 1_000_000_000
"""Of what is held at once of one file, unpacked: 4,000 pings of 60 x 2000 samples of 2 bytes are 960 MB."""
MOST_TEXT_BYTES = 4 << 20
"""Of a file that is parsed whole: as TOML it takes seconds, and a hundred times its size."""
PATIENCE_S = 30.0
"""For what may go on without end however small the file is: a query of a database."""


def opened(path: Path) -> BinaryIO:
    """Open a file to read its bytes. Raises OSError, also for a pipe, a socket or a device: one would wait for ever."""
    fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)  # not even to open a pipe takes time then
    try:
        mode = os.fstat(fd).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(mode):
            raise UnfitFileError(errno.EINVAL, "no file, but a device or a pipe", str(path))
        return os.fdopen(fd, "rb")
    except OSError:
        os.close(fd)
        raise


def content_of(path: Path, most_bytes: int = MOST_TEXT_BYTES) -> bytes:
    """Return all that a file holds. Raises OSError, also for one that is larger than `most_bytes`."""
    with opened(path) as file:
        content = file.read(most_bytes + 1)
    if len(content) > most_bytes:
        raise UnfitFileError(errno.EFBIG, f"larger than {most_bytes / 1e6:.3g} MB", str(path))
    return content


def text_of(path: Path) -> str:
    """Return the text of a file in UTF-8, its lines ended by line feeds only. Raises OSError, UnicodeDecodeError."""
    return content_of(path).decode("utf-8-sig").replace("\r\n", "\n")


def refuse_missing(*paths: Path | None) -> None:
    """Raise OdsError, one line, for the first file or folder that is not there; None is one that was not named."""
    for path in filter(None, paths):
        try:
            path.stat()
        except OSError as error:
            raise OdsError(f"{path}: {os.strerror(error.errno or 0)}") from error
