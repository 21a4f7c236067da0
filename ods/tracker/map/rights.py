"""Permission of this user to write the map, which belongs to root if root started a process before the service did."""

import os
from pathlib import Path

from ods.base.files.ownership import READ_ONLY, name_of, why_not_writable


def missing_permission(path: Path) -> str:
    """Return what this user may not write of the map at `path`, why and what repairs that; empty: nothing."""
    files = [path, *(path.with_name(path.name + ending) for ending in ("-wal", "-shm"))]
    for place, needed, target in (
        *((file, os.R_OK, f"{path}*") for file in files),
        (path.parent, os.X_OK, path.parent),
    ):
        reason = why_not_writable(place, needed) if os.path.exists(place) else ""  # noqa: PTH110  which never raises
        if reason:
            advice = "" if reason == READ_ONLY else f": as root, `chown {name_of(os.geteuid())} {target}`"
            return f"{place} {reason}{advice}"
    return ""
