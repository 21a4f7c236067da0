"""A file in the run folder by which a process leaves its state to its successor, until the computer is started again.

Written whole or not at all, whatever kills the process: a new file takes the place of the old one. The run folder is in
memory on board, so nothing is synchronised with a disk; `StateFileWriter` is for where it is not.
"""

import os
import stat
import struct
import zlib
from pathlib import Path

from ods.base.errors import OdsError

BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
"""CLOCK_MONOTONIC means nothing to another boot."""
MARK = b"ODSKEPT1"
NO_BOOT = bytes(36)
"""Where the id cannot be read: such a file is never believed."""
HEAD = struct.Struct("<8s36sI")
"""MARK, id of the boot, CRC-32 of what follows."""
MODE = 0o600
LONGEST_BYTES = 256 * 1024 * 1024


class StateFileError(OdsError):
    """The file cannot be used; the text is one line."""


class StateFile:
    """One such file."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._part = path.with_name(f"{path.name}.new")
        self._boot = _boot()

    def write(self, content: bytes) -> None:
        """Replace the content. Raises OSError."""
        fd = os.open(self._part, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_NOFOLLOW, MODE)
        try:
            left = [memoryview(HEAD.pack(MARK, self._boot, zlib.crc32(content))), memoryview(content)]
            while left:
                count = os.writev(fd, left)
                while left and count >= len(left[0]):
                    count -= len(left.pop(0))
                if left:
                    left[0] = left[0][count:]
        finally:
            os.close(fd)
        self._part.replace(self._path)

    def read(self) -> bytes | None:
        """Return the content; None when there is none, or of another boot. Raises StateFileError."""
        try:
            fd = os.open(self._path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise StateFileError(f"{self._path}: {error.strerror}") from error
        with os.fdopen(fd, "rb") as file:
            state = os.fstat(fd)
            if not stat.S_ISREG(state.st_mode) or state.st_uid != os.geteuid() or state.st_nlink > 1:
                raise StateFileError(f"{self._path} is not owned by this user")
            whole = file.read(LONGEST_BYTES)
        return self._content(whole)

    def _content(self, whole: bytes) -> bytes | None:
        content = whole[HEAD.size :]
        if len(whole) < HEAD.size:
            raise StateFileError(f"{self._path} is damaged")
        mark, boot, checksum = HEAD.unpack_from(whole)
        if mark != MARK or checksum != zlib.crc32(content):
            raise StateFileError(f"{self._path} is damaged")
        return content if boot == self._boot != NO_BOOT else None


def _boot() -> bytes:
    try:
        return BOOT_ID.read_bytes()[:36]
    except OSError:  # some sandboxes hide it
        return NO_BOOT
