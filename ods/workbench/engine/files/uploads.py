"""Files that come from a browser: looked at before they are kept in the user's folder, under a name that is free."""

import asyncio
import filecmp
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Protocol

from ods.base.errors import OdsError, one_line
from ods.base.files.in_file import opened
from ods.base.settings_file import load
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.data import open_data
from ods.workbench.engine.files.folders import new_beside, uploads_folder
from ods.workbench.engine.files.openable import ENDINGS, SCENE
from ods.workbench.model.state import DataReference

MOST_BYTES = 1 << 30
CLIP, CLIP_BEGINS = ".avi", b"RIFF"
"""Of a clip only the beginning is looked at: what its pictures mean stands in a file beside it."""


class Upload(Protocol):
    """An uploaded file."""

    name: str

    def size(self) -> int:
        """Return how many bytes it has."""

    def iterate(self) -> AsyncIterator[bytes]:
        """Return its content in parts."""


async def keep(upload: Upload) -> Path:
    """Keep what was sent, and return where. Raises OdsError, one line, and keeps nothing, for any other file."""
    wanted = place_of(upload.name)
    if upload.size() > MOST_BYTES:
        raise OdsError(f"{wanted.name}: {upload.size() >> 20} MB, and {MOST_BYTES >> 20} MB are the most")
    with new_beside(wanted) as (new, writing):
        async for part in upload.iterate():
            await asyncio.to_thread(writing.write, part)
        writing.close()
        await asyncio.to_thread(examine, new, wanted.name)
        return await asyncio.to_thread(put, new, wanted)


def place_of(name: str) -> Path:
    """Return where a file of that name would be kept. Raises OdsError."""
    plain = Path(name.replace("\\", "/").replace("\0", "")).name
    if Path(plain).suffix.lower() not in ENDINGS:
        raise OdsError(f"{plain or 'a file'}: the ending must be one of {', '.join(ENDINGS)}")
    folder = uploads_folder()
    if folder is None:
        raise OdsError(f"{plain}: this user has no data folder; set ODS_DATA_DIR")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise OdsError(f"{folder}: {error.strerror}") from error
    return folder / plain


def examine(file: Path, name: str) -> None:
    """Raise OdsError, one line that begins with the name, for a file that is not what its ending says."""
    try:
        if file.suffix.lower() == SCENE:
            load(file, SceneFile)
        elif file.suffix.lower() == CLIP:
            with opened(file) as content:
                if content.read(len(CLIP_BEGINS)) != CLIP_BEGINS:
                    raise OdsError("not a clip of images")
        else:
            _ = open_data(DataReference("file", str(file)), None, [file.parent]).pings[0]
    except OdsError as error:
        raise OdsError(f"not kept: {str(error).replace(str(file), name)}") from error
    except Exception as error:  # whatever a stranger's bytes do to a decoder
        raise OdsError(f"not kept: {name}: {one_line(error)}") from error


def put(new: Path, wanted: Path) -> Path:
    """Move a file that was written whole to its place, or to one named like it that is free; return where it is.

    A file with the same content that is there already will do. Raises OSError.
    """
    new.chmod(0o644)
    place, number = wanted, 0
    while True:
        try:
            place.touch(exist_ok=False)
        except FileExistsError:
            if place.is_file() and filecmp.cmp(place, new, shallow=False):
                return place
        else:
            return new.replace(place)
        number += 1
        place = wanted.with_name(f"{wanted.stem}-{number}{wanted.suffix}")
