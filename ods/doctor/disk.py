"""What processes keep on disk: may this user write the map of obstacles, and recordings?"""

import os
from collections.abc import Iterator
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.files.ownership import why_not_writable
from ods.base.geodesy import SiteSettings
from ods.doctor.finding import Finding
from ods.recording.settings import RecordSettings
from ods.tracker.map.rights import missing_permission
from ods.tracker.map.store import copy_of_map


def map_file(path: Path | None, site: SiteSettings) -> Iterator[Finding]:
    """Check the map file, or the folder where it will be created, without changing either."""
    if path is None:
        yield Finding("note", "map", "tracker.map.path is not set: static objects are lost when the process ends")
        return
    subject = f"map {path}"
    if not os.path.exists(path):  # noqa: PTH110  which never raises
        yield _to_be_made(subject, path)
        return
    reason = missing_permission(path)
    yield Finding("wrong", subject, reason) if reason else _usable(subject, path, site)


def _to_be_made(subject: str, path: Path) -> Finding:
    reason = _why_not_made(path)
    if reason:
        return Finding("wrong", subject, f"cannot be created: {reason}; see tracker.map.path")
    return Finding("good", subject, "will be created at the first start")


def recordings(settings: RecordSettings) -> Iterator[Finding]:
    """Look at the folder of the recordings, if any are made."""
    if not settings.on or settings.folder is None:
        return
    subject = f"recordings {settings.folder}"
    reason = _why_not_made(settings.folder)
    if reason:
        yield Finding("wrong", subject, f"nothing can be recorded: {reason}; see record.folder")
        return
    disk = os.statvfs(_nearest(settings.folder))
    free_mb = disk.f_bavail * disk.f_frsize / 1e6
    if free_mb < settings.keep_free_mb:
        left = f"{free_mb:.0f} MB are free, less than record.keep_free_mb, {settings.keep_free_mb:.0f}"
        yield Finding("wrong", subject, f"nothing is recorded: {left}")
    else:
        yield Finding("good", subject, f"{free_mb / 1e3:.1f} GB are free")


def _why_not_made(path: Path) -> str:
    """Return why nothing can be made at `path`, whatever folders above it are missing; "" where it can."""
    place = _nearest(path)
    reason = why_not_writable(place, os.X_OK) if place.is_dir() else "is not a folder"
    return f"{place} {reason}" if reason else ""


def _nearest(path: Path) -> Path:
    """Return `path`, or the nearest of the folders above it that is there."""
    return next(place for place in (path, *path.parents) if os.path.exists(place))  # noqa: PTH110  which never raises


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
