"""Results of the gallery's demos: pictures and figures, made once and kept in the user's cache folder."""

import contextlib
import os
import tempfile
import threading
from functools import cache
from pathlib import Path
from typing import NamedTuple

import msgspec

from ods.base.errors import OdsError
from ods.base.files.in_file import content_of
from ods.base.files.ownership import is_safe
from ods.workbench.engine.background.own_process import GoesOn, in_own_process, whole
from ods.workbench.engine.files.user_folders import cache_folder
from ods.workbench.engine.gallery.demos import Demo, DemoResult
from ods.workbench.model.state import State

_making = threading.Lock()
"""One at a time, whoever asks."""


class Result(NamedTuple):
    """What there is to see."""

    facts: str
    """What came of it, one line."""
    pictures: list[Path]


@cache
def gallery_folder() -> Path:
    """Return where results are kept: $ODS_CACHE_DIR or the user's cache folder, else a folder for this process only."""
    own = cache_folder()
    if own is not None:
        folder = own / "gallery"
        with contextlib.suppress(OSError):
            folder.mkdir(exist_ok=True)
            if os.access(folder, os.W_OK) and is_safe(folder):
                return folder
    return Path(tempfile.mkdtemp(prefix="ods-gallery-"))


def kept(demo: Demo, base: State, folder: Path) -> Result | None:
    """Return a result that is there already; None: it has to be made. At once."""
    try:
        result = msgspec.json.decode(content_of(folder / f"{_stem(demo, base)}.json"), type=DemoResult)
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError):
        return None
    pictures = [folder / Path(name).name for name in result.pictures]
    return Result(result.facts, pictures) if all(file.is_file() for file in pictures) else None


def made(demo: Demo, base: State, folder: Path, progress: GoesOn = whole) -> Result | None:
    """Return a result, made in a process of its own unless it is there; None: given up. Raises OdsError."""
    with _making:
        if (known := kept(demo, base, folder)) is not None or not progress(0.0):
            return known
        stem = _stem(demo, base)
        try:
            for old in folder.glob(f"{demo.key}-*"):
                old.unlink(missing_ok=True)
            result = in_own_process(_drawn, progress, demo, base, folder / stem)
            if result is None:
                return None
            (folder / f"{stem}.json").write_bytes(msgspec.json.encode(result))
        except OSError as error:
            raise OdsError(f"{folder}: {error.strerror or error}") from error
        return kept(demo, base, folder)


def _stem(demo: Demo, base: State) -> str:
    return f"{demo.key}-{demo.digest(base)}"


def _drawn(progress: GoesOn, demo: Demo, base: State, stem: Path) -> DemoResult | None:
    from ods.workbench.engine.gallery.pictures import draw  # Matplotlib: not in the page's process

    return draw(progress, demo, base, stem)
