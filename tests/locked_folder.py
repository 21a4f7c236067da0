"""A folder that may not be looked into."""

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


def lock(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """Let nobody look into `folder`: root, who may run the tests, may look into any."""

    def refused(call: Callable[..., Any]) -> Callable[..., Any]:
        def refuse(path: Any, *arguments: Any, **how: Any) -> Any:
            if isinstance(path, Path | str) and folder in Path(path).parents:
                raise PermissionError(errno.EACCES, "Permission denied", str(path))
            return call(path, *arguments, **how)

        return refuse

    for name in ("stat", "open"):
        monkeypatch.setattr(os, name, refused(getattr(os, name)))
