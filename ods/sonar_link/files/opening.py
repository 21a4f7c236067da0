"""Opens any recording of pings: the reader is chosen by what the file holds, its suffix only decides in doubt."""

from collections.abc import Callable
from pathlib import Path

from ods.sonar_link import drf
from ods.sonar_link.files import aris, avi, oculus
from ods.sonar_link.files.aris import read_aris
from ods.sonar_link.files.fan_image import FanGeometry, read_fan_clip
from ods.sonar_link.files.npz import read_ping_file
from ods.sonar_link.files.oculus import read_oculus
from ods.sonar_link.files.ping_sequence import PingFileError, PingSequence
from ods.sonar_link.files.s7k_file import read_s7k

__all__ = ["PingFileError", "PingSequence", "open_pings"]

Reader = Callable[[Path], PingSequence]

BY_SIGNATURE: tuple[tuple[int, bytes, Reader], ...] = (
    (0, b"PK", read_ping_file),
    (0, aris.SIGNATURE, read_aris),
    (0, oculus.SIGNATURE, read_oculus),
    (drf.SYNC_AT, drf.SYNC, read_s7k),
)
"""Where a signature stands, the signature, who reads such a file."""
BY_SUFFIX: dict[str, Reader] = {".npz": read_ping_file, ".aris": read_aris, ".raw": read_oculus, ".s7k": read_s7k}


def open_pings(path: Path, fan: FanGeometry | None = None) -> PingSequence:
    """Open a .npz, .s7k, .aris or Oculus .raw recording, or an .avi clip of fan images whose geometry is `fan`.

    Raises PingFileError, whose text is one line.
    """
    try:
        with path.open("rb") as file:
            start = file.read(16)
    except OSError as error:
        raise PingFileError(f"{path}: {error.strerror}") from error
    if not start:
        raise PingFileError(f"{path}: the file is empty")
    if avi.is_avi(start):
        if fan is None:
            raise PingFileError(f"{path}: a clip of images, whose fan geometry must be given (--fan)")
        return read_fan_clip(path, fan)
    for offset, signature, reader in BY_SIGNATURE:
        if start[offset:].startswith(signature):
            return reader(path)
    by_suffix = BY_SUFFIX.get(path.suffix.lower())
    if by_suffix is None:
        raise PingFileError(f"{path}: none of the known formats: .npz, .s7k, .aris, Oculus .raw, .avi")
    return by_suffix(path)
