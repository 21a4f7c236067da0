"""Debian packages unpacked into a cache folder: no root needed, and nothing on the machine changes."""

import fcntl
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from in_vcan.job import NotHereError, say


def cache() -> Path:
    """Return the folder of what was fetched; it can be deleted at any time."""
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "in-vcan"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def unpacked(package: str) -> Path:
    """Return the folder with the package's files, fetched at the first call. Raises NotHereError."""
    folder = cache() / package
    with (cache() / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.exists():
            _need(package, "apt-get", "dpkg-deb")
            say(f"fetching the Debian package {package}, once")
            with tempfile.TemporaryDirectory(dir=cache()) as scratch:
                _fetch(package, Path(scratch))
                (Path(scratch) / "root").rename(folder)
    return folder


def depends(package: str) -> list[str]:
    """Return the packages that a package depends on: the kernel's is named by one without a version."""
    done = subprocess.run(
        ["apt-cache", *_own_lists(), "depends", "--important", package], capture_output=True, text=True
    )
    return [line.partition(":")[2].strip() for line in done.stdout.splitlines() if "Depends:" in line]


def install(package: str) -> None:
    """Install a package with all that it depends on, as only root can. Raises NotHereError."""
    if os.geteuid():
        raise NotHereError(f"please install, as root: apt-get install {package}")
    _need(package, "apt-get")
    say(f"installing the Debian package {package}")
    words = ["apt-get", "install", "-y", "-q", "--no-install-recommends", package]
    _update_and_again(words, Path("/"), ["apt-get", "update", "-q"])


def _need(package: str, *programs: str) -> None:
    for program in programs:
        if not shutil.which(program):
            raise NotHereError(f"no {package}, and no {program} to get it by")


def _own_lists() -> list[str]:
    """Return apt's options for package lists of our own, which anybody may bring up to date."""
    lists = cache() / "lists"
    (lists / "partial").mkdir(parents=True, exist_ok=True)
    return ["-o", f"Dir::State::Lists={lists}", "-o", f"Dir::Cache={cache()}"]


def _fetch(package: str, scratch: Path) -> None:
    options = ["-q", *_own_lists()]
    _update_and_again(["apt-get", *options, "download", package], scratch, ["apt-get", *options, "update"])
    (file,) = scratch.glob("*.deb")
    _run(["dpkg-deb", "-x", str(file), str(scratch / "root")], scratch)


def _update_and_again(words: list[str], folder: Path, update: list[str]) -> None:
    """Run apt-get; if it fails, as it does with old lists of packages, bring them up to date and try once more."""
    try:
        _run(words, folder)
    except NotHereError:
        _run(update, folder)
        _run(words, folder)


def _run(words: list[str], folder: Path) -> None:
    environment = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    done = subprocess.run(words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        said = [line for line in done.stderr.splitlines() if line.startswith("E:")] or [f"status {done.returncode}"]
        raise NotHereError(f"{' '.join([words[0], words[-2], words[-1]])}: {said[0]}")
