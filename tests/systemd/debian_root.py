"""The root of a Debian with nothing but what `make install` asks for, and what goes into it. Only root can make one."""

import fcntl
import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

from in_vcan import debian
from in_vcan.job import NotHereError, say

PROJECT = Path(__file__).parents[2]
PACKAGES = ("systemd", "systemd-sysv", "dbus", "udev", "kmod", "iproute2", "procps", "python3", "python3-venv", "make")
"""procps is on every computer that is more than a container; the last two are what docs/installation.md asks for."""
BARE = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root"}
ENTER = 'mount -t proc proc "$1/proc" && mount --rbind /dev "$1/dev" && exec chroot "$@"'


def base() -> Path:
    """Return the folder of a bare Debian of this host's release, made at the first call. Raises NotHereError."""
    if os.geteuid():
        raise NotHereError("only root can make the root of a Debian")
    system = platform.freedesktop_os_release()
    suite = system.get("VERSION_CODENAME", "")
    if system.get("ID") != "debian":
        raise NotHereError("this is no Debian, so there is none to install on")
    words = ["debootstrap", "--variant=minbase", f"--include={','.join(PACKAGES)}"]
    folder = debian.cache() / f"{suite}-{hashlib.sha256(' '.join(words).encode()).hexdigest()[:8]}"
    with (debian.cache() / "root-lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not folder.exists():
            if not shutil.which("debootstrap"):
                debian.install("debootstrap")
            say(f"making a Debian {suite} in {folder}, once")
            scratch = folder.with_suffix(".new")
            subprocess.run(["rm", "-rf", scratch], check=True)
            done = subprocess.run([*words, suite, scratch, _mirror(suite)], capture_output=True, text=True)
            if done.returncode:
                raise NotHereError(f"debootstrap: {(done.stdout + done.stderr).strip().splitlines()[-1]}")
            scratch.rename(folder)
    return folder


def _mirror(suite: str) -> str:
    """Return where this host gets its own packages from."""
    words = ["apt-get", "indextargets", "--format", "$(RELEASE) $(REPO_URI)", "Created-By: Packages"]
    for line in subprocess.run(words, capture_output=True, text=True).stdout.splitlines():
        release, _, uri = line.partition(" ")
        if release == suite:
            return uri
    raise NotHereError(f"apt-get knows no mirror of {suite}")


def wheels(root: Path) -> Path:
    """Return a folder with all that the wheel needs, for the root's Python, fetched as the host's pip does it."""
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())
    needed = [*project["project"]["dependencies"], *project["build-system"]["requires"]]
    python = (root / "usr/bin/python3").readlink().name.removeprefix("python")
    constraints = PROJECT / "constraints.txt"
    text = " ".join([python, *needed, constraints.read_text()])
    folder = debian.cache() / f"wheels-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
    if not folder.exists():
        scratch = folder.with_suffix(".new")
        words = [sys.executable, "-m", "pip", "download", "--quiet", f"--dest={scratch}", f"--constraint={constraints}"]
        done = subprocess.run(
            [*words, "--python-version", python, "--only-binary", ":all:", *needed], capture_output=True, text=True
        )
        if done.returncode:
            raise NotHereError(f"pip download: {done.stderr.strip().splitlines()[-1]}")
        scratch.rename(folder)
    return folder


def put_sources(folder: Path) -> None:
    """Copy the project's files, as git knows them, into a folder."""
    words = ["git", "-C", str(PROJECT), "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    folder.mkdir(parents=True)
    present = "\n".join(name for name in listed.splitlines() if os.path.lexists(PROJECT / name))
    packed = ["tar", f"--directory={PROJECT}", "--create", "--files-from=-"]
    archive = subprocess.run(packed, input=present.encode(), capture_output=True, check=True).stdout
    subprocess.run(["tar", "--extract", "--no-same-owner", f"--directory={folder}"], input=archive, check=True)


def project_wheel(folder: Path, version: str | None) -> Path:
    """Return a wheel of the project, of another version if one is given, made in `folder`."""
    source = folder / "source"
    put_sources(source)
    if version:
        init = source / "ods" / "__init__.py"
        init.write_text(re.sub("__version__ = .*", f'__version__ = "{version}"', init.read_text()))
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "wheel", "--no-build-isolation"]
    subprocess.run([*pip, "--no-deps", "--no-index", "--wheel-dir", str(folder), str(source)], check=True)
    return next(folder.glob("*.whl"))


def inside(root: Path, *command: str, **environment: str) -> "subprocess.CompletedProcess[str]":
    """Run a command in the root, as its root, with /proc and /dev; what it leaves running is killed."""
    return subprocess.run(
        ["unshare", "--mount", "--pid", "--fork", "--kill-child", "sh", "-c", ENTER, "sh", str(root), *command],
        env=BARE | environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def make_disk(root: Path, image: Path, size_mb: int = 2000) -> None:
    """Write the root into a disk image."""
    words = ["mke2fs", "-q", "-t", "ext4", "-d", str(root), str(image), f"{size_mb}M"]
    subprocess.run(words, check=True, capture_output=True)
