"""`benchmarks.installation.onboard`: what the program takes on board: disk, memory, and seconds to the first list.

A wheel is built and installed into a clean virtual environment, as on a vehicle; its `ods run` is measured against the
bench's simulator, which runs from here.
"""

import argparse
import contextlib
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import msgspec
import psutil

from ods.base.settings_file import load
from ods.bench.collector import Collector
from ods.bench.run_files import write_configs
from ods.bench.settings import BenchConfig
from ods.runtime.processes import on_board

LONGEST_S = 60.0
SIMULATOR_S = 5.0
"""The simulator starts, and waits for somebody to listen."""
_BARE = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | {"PYTHONSAFEPATH": "1"}
"""Nothing of the source tree is imported."""


def main() -> None:
    """Print the table of docs/installation.md."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--seconds", type=float, default=10.0, help="of work, before memory is read")
    parser.add_argument("--starts", type=int, default=3, help="of `ods run`; memory is that of the last")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="ods-onboard-") as name:
        folder = Path(name)
        python = _installed(folder)
        _print_disk(folder / "venv")
        for start in range(args.starts):
            seconds = args.seconds if start == args.starts - 1 else 0.0
            first_s, memory = _start([str(python), "-m", "ods"], folder, seconds)
            print(f"first valid list {first_s:.1f} s after `ods run`")
        for process, (rss, pss, own) in memory.items():
            print(f"    {process:9} {rss:4.0f} MB resident, {pss:4.0f} with a share of shared, {own:4.0f} its own")


def _installed(folder: Path) -> Path:
    """Build the wheel and install it; return the Python of the environment."""
    venv, pip = folder / "venv", [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*pip, "wheel", "--no-deps", "--wheel-dir", str(folder), "."], check=True, env=_BARE)
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(venv)], check=True)
    python, wheel = venv / "bin" / "python", next(folder.glob("ods-*.whl"))
    subprocess.run(
        [*pip, "--python", str(python), "install", "-c", "constraints.txt", str(wheel)], check=True, env=_BARE
    )
    return python


def _print_disk(venv: Path) -> None:
    parts = {
        part.name: _size_mb(part) for part in next(venv.glob("lib/python*/site-packages")).iterdir() if part.is_dir()
    }
    largest = sorted(parts.items(), key=lambda item: -item[1])[:6]
    named = ", ".join(f"{name} {size:.0f}" for name, size in largest)
    print(f"disk: {_size_mb(venv):.0f} MB, without pip; of that {named}")


def _size_mb(folder: Path) -> float:
    return sum(file.stat().st_blocks * 512 for file in folder.rglob("*") if not file.is_symlink()) / 1e6


def _start(ods: list[str], folder: Path, seconds: float) -> tuple[float, dict[str, tuple[float, float, float]]]:
    """Return the seconds from `ods run` to the first valid list, and each process's memory some seconds later."""
    bench = load(Path("config/bench.toml"), BenchConfig)
    bus = msgspec.structs.replace(bench.bus, run_dir=folder / "run")
    bench = msgspec.structs.replace(bench, bus=bus, out=folder / "out", seconds=LONGEST_S)
    onboard, simulator = write_configs(bench)
    collector = Collector(bus.run_dir)
    with contextlib.closing(collector), _running([sys.executable, "-m", "ods", "sim", "--config", str(simulator)]):
        time.sleep(SIMULATOR_S)
        begun = time.monotonic()
        with _running([*ods, "run", "--config", str(onboard)]) as run:
            while not any(message.valid for _, message in collector.record.lists):
                collector.listen(0.02)
                if time.monotonic() - begun > LONGEST_S or run.poll() is not None:
                    raise SystemExit(f"no valid list within {LONGEST_S:.0f} s: `ods run` ended, or is slow")
            first_s = time.monotonic() - begun
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                collector.listen(0.1)
            return first_s, {name: _memory_mb(pid) for name, pid in _children(run.pid)}


@contextlib.contextmanager
def _running(command: list[str]) -> Iterator["subprocess.Popen[bytes]"]:
    no_compiler = _BARE | {"PATH": str(Path(command[0]).parent)}
    environment = os.environ if command[0] == sys.executable else no_compiler
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(command, env=environment, stdout=quiet, stderr=quiet)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(10.0)


def _children(pid: int) -> Iterator[tuple[str, int]]:
    yield "run", pid
    names = {process.name for process in on_board()}
    for child in psutil.Process(pid).children():
        yield next(word for word in child.cmdline() if word in names), child.pid


def _memory_mb(pid: int) -> tuple[float, float, float]:
    """Return resident memory, the same with shared pages divided by their users, and pages of this process only."""
    text = Path(f"/proc/{pid}/smaps_rollup").read_text()
    kb = {name: int(value) for name, value in re.findall(r"^(\w+): +(\d+) kB", text, re.M)}
    mb = 1024 / 1e6
    return kb["Rss"] * mb, kb["Pss"] * mb, (kb["Private_Clean"] + kb["Private_Dirty"]) * mb


if __name__ == "__main__":
    main()
