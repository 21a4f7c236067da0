"""Arrays of an .npz file, which may come from anywhere: what a file of a few MB unpacks to is looked at before."""

import math
import os
import struct
import zipfile
from collections.abc import Collection
from pathlib import Path
from typing import BinaryIO

import numpy as np

from ods.base.arrays import AnyArray
from ods.base.errors import one_line
from ods.base.files.in_file import MOST_BYTES, opened

MOST_DIRECTORY_BYTES = 1_000_000
"""Of the archive's own list, of which zipfile makes some ten times as much, whichever arrays are wanted."""
_SUFFIX = ".npy"
_END = struct.Struct("<4s8xI6x")
_END_MARK, _LONGEST_END = b"PK\x05\x06", 22 + 0xFFFF
"""The end of a zip archive: mark, bytes of the list; with a comment of up to 64 KiB behind it."""
_ZIP64_MARK, _ZIP64_BYTES = b"PK\x06\x07", 20
"""What stands before it where the numbers of zip64 count."""


def load_npz(path: Path, names: Collection[str] | None = None, most_bytes: int = MOST_BYTES) -> dict[str, AnyArray]:
    """Return the arrays of a file by their names, or those of some names that it has.

    Raises OSError, and ValueError, one line that does not name the file, where it is damaged, holds Python objects,
    or would unpack to more than `most_bytes`.
    """
    try:
        with opened(path) as file:
            if _directory_bytes(file) > MOST_DIRECTORY_BYTES:
                raise _RefusedError("holds very many arrays")
            archive = zipfile.ZipFile(file)
            wanted = [each for each in archive.infolist() if _is_wanted(each.filename, names)]
            size = sum(member.file_size for member in wanted)
            if size > most_bytes:
                raise _RefusedError(f"unpacks to {size / 1e6:,.0f} MB, more than {most_bytes / 1e6:,.0f} MB")
            return {member.filename.removesuffix(_SUFFIX): _array(archive, member) for member in wanted}
    except OSError as error:
        raise error if error.errno else ValueError(f"not a whole .npz file: {one_line(error)}") from error
    except _RefusedError:
        raise
    except Exception as error:  # what zipfile, zlib and numpy raise at damaged bytes is no list that ends
        raise ValueError(f"not a whole .npz file: {one_line(error)}") from error


def _directory_bytes(file: BinaryIO) -> int:
    """Return how many bytes the list of an archive has, 0 where there is none; leave the file at its start.

    Looks for its end where zipfile does. One with a second end, of zip64, counts as 4 GiB: only then it needs one.
    """
    size = file.seek(0, os.SEEK_END)
    file.seek(max(0, size - _LONGEST_END))
    tail = file.read()
    file.seek(0)
    at = len(tail) - _END.size
    if not (tail[at:].startswith(_END_MARK) and tail.endswith(b"\0\0")):
        at = tail.rfind(_END_MARK)
    if not 0 <= at <= len(tail) - _END.size:
        return 0
    is_zip64 = tail[:at][-_ZIP64_BYTES:].startswith(_ZIP64_MARK)
    return 1 << 32 if is_zip64 else int(_END.unpack_from(tail, at)[1])


class _RefusedError(ValueError):
    """The file is whole, but not to be read."""


def _is_wanted(member: str, names: Collection[str] | None) -> bool:
    return member.endswith(_SUFFIX) and (names is None or member.removesuffix(_SUFFIX) in names)


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> AnyArray:
    with archive.open(member) as file:
        read = np.lib.format.read_array_header_1_0
        if np.lib.format.read_magic(file)[0] > 1:
            read = np.lib.format.read_array_header_2_0
        shape, _, dtype = read(file)
        if dtype.hasobject:
            raise ValueError(f"{member.filename} holds Python objects")
        if math.prod(shape) * dtype.itemsize > member.file_size:  # numpy would reserve that much first
            raise ValueError(f"{member.filename} tells of more than it holds")
    with archive.open(member) as file:
        array: AnyArray = np.lib.format.read_array(file, allow_pickle=False)
        return array
