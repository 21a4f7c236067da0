"""`benchmarks.installation.wheels`: has every pinned dependency a wheel for the computers of vehicles, 64-bit ARM?

pip is asked, for each line of constraints.txt, to choose a file as it would on such a computer; nothing is installed.
The exit code is 1 when a wheel is missing.
"""

import argparse
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

GLIBC = ("manylinux_2_28", "manylinux_2_27", "manylinux_2_17", "manylinux2014")
"""Debian 10 and later, Ubuntu 20.04 and later."""


def main() -> int:
    """Print the pinned dependencies that have no wheel; return 1 if there are any."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--machine", default="aarch64")
    parser.add_argument("--python", default=platform.python_version())
    args = parser.parse_args()
    lines = (line.partition("#")[0].strip() for line in Path("constraints.txt").read_text().splitlines())
    pinned = [line for line in lines if line]
    missing = [line for line in pinned if not _has_wheel(line, args.machine, args.python)]
    for line in missing:
        print(f"{line}: no wheel")
    print(f"{len(pinned) - len(missing)} of {len(pinned)} have a wheel for {args.machine}, Python {args.python}")
    return 1 if missing else 0


def _has_wheel(pinned: str, machine: str, python: str) -> bool:
    platforms = [f"--platform={glibc}_{machine}" for glibc in GLIBC]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--dry-run"]
        command += ["--no-deps", "--only-binary=:all:", f"--target={folder}", f"--python-version={python}"]
        return subprocess.run([*command, *platforms, pinned], capture_output=True, check=False).returncode == 0


if __name__ == "__main__":
    sys.exit(main())
