"""Arrays of an .npz file, which may come from anywhere: what a file of a few MB unpacks to is looked at before."""

import math
import zipfile
from collections.abc import Collection
from pathlib import Path

import numpy as np

from ods.base.arrays import AnyArray
from ods.base.errors import one_line
from ods.base.in_file import MOST_BYTES, opened

_SUFFIX = ".npy"


def load_npz(path: Path, names: Collection[str] | None = None, most_bytes: int = MOST_BYTES) -> dict[str, AnyArray]:
    """Return the arrays of a file by their names, or those of some names that it has.

    Raises OSError, and ValueError, one line that does not name the file, where it is damaged, holds Python objects,
    or would unpack to more than `most_bytes`.
    """
    try:
        with opened(path) as file, zipfile.ZipFile(file) as archive:
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
