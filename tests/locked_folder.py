"""A folder that may not be looked into."""

import errno
import os
from pathlib import Path
from typing import Any

import pytest


def lock(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """Let nobody look into `folder`: root, who may run the tests, may look into any."""
    stat = os.stat

    def refuse(path: Any, **how: Any) -> os.stat_result:
        if isinstance(path, Path | str) and folder in Path(path).parents:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return stat(path, **how)

    monkeypatch.setattr(os, "stat", refuse)
