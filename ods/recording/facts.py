"""Facts about computer and program in a recording: replay gives the same bytes only on the same ones."""

import hashlib
import platform
from importlib import metadata
from pathlib import Path

from ods import __version__
from ods.base import clock

LIBRARIES = ("numpy", "msgspec", "pyzmq", "mcap", "zstandard")
BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
CPU = Path("/proc/cpuinfo")


def facts(config_text: str) -> dict[str, str]:
    """Return them by name, with the offset of UTC that all times of the recording have."""
    cpu = _cpu()
    return {
        "version": __version__,
        "utc_offset_ns": str(max(0, clock.utc_offset_ns())),
        "utc_synchronized": str(clock.synchronized()).lower(),
        "boot_id": boot_id(),
        "host": platform.node(),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "cpu": cpu.get("model name", platform.processor()),
        "cpu_flags": cpu.get("flags", cpu.get("Features", "")),
        "config_sha256": hashlib.sha256(config_text.encode()).hexdigest(),
        "python": platform.python_version(),
        "libc": " ".join(platform.libc_ver()),
        **{name: _version(name) for name in LIBRARIES},
    }


def boot_id() -> str:
    """Return the name of this start of the computer: CLOCK_MONOTONIC means nothing to another one."""
    try:
        return BOOT_ID.read_text().strip()
    except OSError:
        return ""


def _cpu() -> dict[str, str]:
    """Return the kernel's description of the first core."""
    try:
        first = CPU.read_text().split("\n\n")[0]
    except OSError:
        return {}
    pairs = (line.partition(":") for line in first.splitlines())
    return {name.strip(): value.strip() for name, _, value in pairs}


def _version(library: str) -> str:
    try:
        return metadata.version(library)
    except metadata.PackageNotFoundError:
        return ""
