"""Folders of the user who runs the workbench: what can be made again, and what is kept."""

import os
from pathlib import Path

from ods.base.files.ownership import is_safe


def cache_folder() -> Path | None:
    """Return $ODS_CACHE_DIR/ods, or the user's cache folder; None: there is none that only the user writes."""
    return _own("ODS_CACHE_DIR", "XDG_CACHE_HOME", ".cache")


def data_folder() -> Path | None:
    """Return $ODS_DATA_DIR/ods, or the user's folder of data, where uploads and the list of recent files are kept.

    None: there is none that only the user writes.
    """
    return _own("ODS_DATA_DIR", "XDG_DATA_HOME", ".local/share")


def _own(ours: str, of_desktop: str, under_home: str) -> Path | None:
    home = os.environ.get("HOME", "")
    named = (os.environ.get(name, "") for name in (ours, of_desktop))
    for root in filter(None, (*named, f"{home}/{under_home}" if home else "")):
        folder = Path(root, "ods")
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK) and is_safe(folder):
            return folder
    return None
