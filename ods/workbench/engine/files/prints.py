"""Files of prints and movies: their endings, where they may be written, and the hash of a configuration on them."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

from ods.base.errors import OdsError
from ods.workbench.engine.files.folders import writable
from ods.workbench.model.short_tables import short_tables
from ods.workbench.model.state import Tuning

PICTURES, MOVIES = (".png", ".svg", ".pdf"), (".webp", ".gif")


def config_hash(tuning: Tuning) -> str:
    """Return twelve hexadecimal digits that another configuration of pipeline and tracker has not."""
    text = json.dumps(short_tables(tuning.mission()), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def place_to_write(file: Path, endings: tuple[str, ...], folders: Sequence[Path]) -> Path:
    """Return where a file is written. Raises OdsError for another ending, or a place outside the folders."""
    if file.suffix.lower() not in endings:
        raise OdsError(f"{file}: the ending must be one of {', '.join(endings)}")
    place = writable(file, folders)
    if not place.parent.is_dir():
        raise OdsError(f"{file}: no such folder")
    return place
