"""The map of obstacles: may this user write it?"""

import os
from collections.abc import Iterator
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.geodesy import SiteSettings
from ods.doctor.finding import Finding
from ods.tracker.map.rights import hindrance
from ods.tracker.map.store import copy_of_map


def examine(path: Path | None, site: SiteSettings) -> Iterator[Finding]:
    """Look at the map's file, or where it is to be made, without touching either."""
    if path is None:
        yield Finding("note", "map", "tracker.map.path is not set: static objects are lost when the process ends")
        return
    subject = f"map {path}"
    if not os.path.exists(path):  # noqa: PTH110  which never raises
        yield _to_be_made(subject, path)
        return
    reason = hindrance(path)
    yield Finding("wrong", subject, reason) if reason else _usable(subject, path, site)


def _to_be_made(subject: str, path: Path) -> Finding:
    folder = next(folder for folder in path.parents if os.path.exists(folder))  # noqa: PTH110
    if not folder.is_dir():
        return Finding("wrong", subject, f"cannot be created: {folder} is not a folder; see tracker.map.path")
    if not os.access(folder, os.W_OK | os.X_OK):
        fault = f"cannot be created: {folder} belongs to {_owner(folder)}, and is not writable for this user"
        return Finding("wrong", subject, f"{fault}; see tracker.map.path")
    return Finding("good", subject, "will be created at the first start")


def _usable(subject: str, path: Path, site: SiteSettings) -> Finding:
    try:
        store = copy_of_map(path)
        origin = store.origin_deg()
        store.close()
    except OdsError as error:
        return Finding("wrong", subject, str(error).removeprefix(f"{subject}: "))
    if origin != (site.latitude_deg, site.longitude_deg):
        return Finding(
            "wrong", subject, f"its origin is {origin[0]}, {origin[1]}, not [site]: give each site its own map"
        )
    return Finding("good", subject, "can be read and written")


def _owner(path: Path) -> str:
    try:
        return path.owner()
    except KeyError:  # of another machine
        return f"user {path.stat().st_uid}"
