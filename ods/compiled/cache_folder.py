"""Where compiled kernels are kept: in a folder that nobody else can write, named after the sources of the kernels."""

import hashlib
import os
import re
import shutil
import stat
from collections.abc import Iterator
from functools import cache
from pathlib import Path

_FOLDER = "kernels-"
_IMPORT = re.compile(rb"^[ \t]*(?:from[ \t]+([\w.]+)[ \t]+import[ \t]+([\w, ]+|\([^)]*\))|import[ \t]+([\w.]+))", re.M)


@cache
def package_of(source: Path) -> Path:
    """Return the folder of the outermost package that a source file belongs to; its own folder if it is of none."""
    package = source.parent
    while (package / "__init__.py").exists() and (package.parent / "__init__.py").exists():
        package = package.parent
    return package


@cache
def folders(package: Path) -> tuple[Path, ...]:
    """Return where the compiled kernels of `package` may be, best first; not all of these folders need exist.

    $ODS_CACHE_DIR, systemd's $CACHE_DIRECTORY, `__pycache__` of the package, the user's cache folder.
    """
    name = _FOLDER + sources_digest(package)
    return tuple(folder / name for folder in _roots(package))


def _roots(package: Path) -> Iterator[Path]:
    for variable in ("ODS_CACHE_DIR", "CACHE_DIRECTORY"):
        for folder in filter(None, os.environ.get(variable, "").split(":")):
            yield Path(folder, package.name)
    yield package / "__pycache__"
    home = os.environ.get("HOME", "")
    users = os.environ.get("XDG_CACHE_HOME") or (f"{home}/.cache" if home else "")
    if users:
        yield Path(users, "ods", package.name)


@cache
def writable_folder(package: Path) -> Path | None:
    """Return the first of `folders` that can be written and that nobody else can write, made if need be.

    What older sources left beside it is removed.
    """
    return next(filter(_made, folders(package)), None)


def _made(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if not (os.access(folder, os.W_OK) and is_safe(folder)):
            return False
    except OSError:
        return False
    for other in folder.parent.glob(f"{_FOLDER}*"):
        if other != folder:
            shutil.rmtree(other, ignore_errors=True)
    return True


def is_safe(path: Path) -> bool:
    """Tell whether nobody but root and this user can write `path`, nor put another in its place."""
    return not weakness(path)


def weakness(path: Path) -> str:
    """Say why somebody else could write `path`, or put another in its place; "" when nobody could."""
    try:
        return next(filter(None, map(_not_ours, (path.resolve(), *path.resolve().parents))), "")
    except OSError as error:
        return f"{path}: {error.strerror}"


def _not_ours(place: Path) -> str:
    state = place.stat()
    if state.st_uid not in (0, os.geteuid()):
        return f"{place} belongs to another user"
    others_write = state.st_mode & (stat.S_IWGRP | stat.S_IWOTH) and not state.st_mode & stat.S_ISVTX
    return f"{place} can be written by others (chmod go-w)" if others_write else ""


@cache
def sources_digest(package: Path) -> str:
    """Return a digest of all sources of `package` that its kernels are made of.

    These are the files with kernels, and what they import: constants and records are compiled in. Numba itself looks
    for changes in a kernel's own file only: it would go on with callees as they were before an update.
    """
    texts = {source: source.read_bytes() for source in package.rglob("*.py")}
    waiting = [source for source, text in texts.items() if b"@kernel" in text or b"@compiled" in text]
    reached = set(waiting)
    while waiting:
        for source in _imported(texts[waiting.pop()], package):
            if source in texts and source not in reached:
                reached.add(source)
                waiting.append(source)
    digest = hashlib.sha256()
    for source in sorted(reached):
        digest.update(str(source.relative_to(package)).encode() + b"\0" + texts[source])
    return digest.hexdigest()[:16]


def _imported(text: bytes, package: Path) -> Iterator[Path]:
    """Yield the files that the import statements of a source may mean."""
    top = package.parent if (package / "__init__.py").exists() else package
    for found in _IMPORT.finditer(text):
        module = (found[1] or found[3]).decode()
        place = top.joinpath(*module.split("."))
        yield place.with_suffix(".py")
        for name in re.findall(r"\w+", (found[2] or b"").decode()):
            yield place / f"{name}.py"
