"""May this user write the map? It is another's where root made it, by a first start by hand, before the service."""

import os
import pwd
from pathlib import Path


def hindrance(path: Path) -> str:
    """Return what this user may not write of the map at `path`, whose it is and what repairs that; empty: nothing."""
    files = [path, *(path.with_name(path.name + ending) for ending in ("-wal", "-shm"))]
    for place, needed, target in (
        *((file, os.R_OK, f"{path}*") for file in files),
        (path.parent, os.X_OK, path.parent),
    ):
        if os.path.exists(place) and not os.access(place, needed | os.W_OK):  # noqa: PTH110  which never raises
            me, owner = _name(os.geteuid()), _name(place.stat().st_uid)
            return f"{place} may not be written by user {me}, as it belongs to {owner}: as root, `chown {me} {target}`"
    return ""


def _name(uid: int) -> str:
    try:
        return pwd.getpwuid(uid).pw_name
    except KeyError:  # of another machine
        return str(uid)
