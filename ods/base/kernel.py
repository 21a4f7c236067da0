"""The one way the on-board code compiles: numba, cached on disk, NaN and infinity kept as IEEE 754 has them."""

import hashlib
import os
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

from numba import config, njit

F = TypeVar("F", bound=Callable[..., Any])

_FASTMATH = {"reassoc", "contract", "arcp", "nsz"}
"""Sums may be reordered, so that they vectorise. Not `nnan`, not `ninf`: bad samples must compare as false."""
_CHOSEN_BY_USER = "NUMBA_CACHE_DIR" in os.environ
_FOLDER = "kernels-"


def kernel(function: F) -> F:
    """Compile `function` at its first call for the array types it is given; later runs load it from the cache."""
    return compiled(function, fastmath=_FASTMATH)


def compiled(function: F, **options: Any) -> F:
    """Compile `function` by numba with these options, division by zero giving infinity, and cache it."""
    if not _CHOSEN_BY_USER:
        config.CACHE_DIR = cache_folder(_package_of(Path(function.__code__.co_filename)))  # type: ignore[attr-defined]
    return cast(F, njit(cache=True, error_model="numpy", **options)(function))


@cache
def _package_of(source: Path) -> Path:
    """Return the folder of the outermost package that a source file belongs to; its own folder if it is of none."""
    package = source.parent
    while (package / "__init__.py").exists() and (package.parent / "__init__.py").exists():
        package = package.parent
    return package


@cache
def cache_folder(package: Path) -> str:
    """Return the folder for what is compiled of a package; empty, which leaves it to numba, where none can be made.

    It is named after the sources of all kernels in all its folders. Numba compiles a kernel together with those it
    calls, but looks for changes in its own file only: it would go on with callees as they were before an update.
    """
    digest = hashlib.sha256()
    for source in sorted(package.rglob("*.py")):
        text = source.read_bytes()
        if b"@kernel" in text or b"@compiled" in text:
            digest.update(text)
    folder = package / "__pycache__" / f"{_FOLDER}{digest.hexdigest()[:16]}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return ""
    for other in folder.parent.glob(f"{_FOLDER}*"):
        if other != folder:
            shutil.rmtree(other, ignore_errors=True)
    return str(folder)
