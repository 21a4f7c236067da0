"""Starts the simulator and `ods run` as a user would, listens as a planner would."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import msgspec
import psutil
import tomli_w

from ods.base import clock
from ods.base.errors import OdsError
from ods.base.settings import Settings
from ods.base.settings_file import load
from ods.bench import report
from ods.bench.collector import Collector, RunRecord
from ods.bench.settings import BenchConfig
from ods.config import OnboardConfig
from ods.sim_sonar.device.sonar_line import port_of
from ods.sim_sonar.ins.can_bus import can_of

START_S = 180.0
"""The first start compiles the pipeline's and the simulator's kernels."""
AFTER_S = 1.0
"""Time for the last lists to arrive."""


class BenchError(OdsError):
    """The bench could not run; the text says why."""


def fly_mission(settings: BenchConfig) -> RunRecord:
    """Run one mission and return what was seen of it."""
    onboard_file, sim_file = _write_configs(settings)
    with ExitStack() as stack:
        collector = Collector(settings.bus.run_dir)
        stack.callback(collector.close)
        run_log, sim_log = settings.out / "run.log", settings.out / "sim.log"
        onboard = stack.enter_context(_started("run", onboard_file, run_log))
        line = report.ProgressLine()
        _wait_ready(collector, ["pipeline", "tracker"], onboard, run_log, line)
        simulator = stack.enter_context(_started("sim", sim_file, sim_log))
        _wait_ready(collector, ["sim", "sonar", "nav"], simulator, sim_log, line)
        _fly(collector, settings, onboard, simulator, line)
        return collector.record


def _write_configs(settings: BenchConfig) -> tuple[Path, Path]:
    """Write the configurations of this run, complete and absolute, into the results folder."""
    run_dir = settings.bus.run_dir
    settings.out.mkdir(parents=True, exist_ok=True)
    for old in settings.out.glob("map.sqlite*"):
        old.unlink()
    interface, channel = can_of(settings.sim.can, run_dir)
    onboard = _as_dict(load(settings.onboard, OnboardConfig))
    onboard["bus"]["run_dir"] = str(run_dir)
    onboard["sonar"] |= {"port": port_of(settings.sim, run_dir), "latency_ms": settings.sim.sonar_latency_ms}
    onboard["nav"]["can"] |= {"interface": interface, "channel": channel}
    onboard["tracker"]["map"]["path"] = str(settings.out / "map.sqlite")
    files = settings.out / "onboard.toml", settings.out / "bench.toml"
    for file, content in zip(files, (onboard, _as_dict(settings)), strict=True):
        file.write_text(tomli_w.dumps(content), encoding="utf-8")
    return files


def _as_dict(settings: Settings) -> dict[str, Any]:
    """Return the settings as TOML can hold them: paths as text, what is None left out."""

    def without_none(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: without_none(item) for key, item in value.items() if item is not None}
        return [without_none(item) for item in value] if isinstance(value, list) else value

    plain: dict[str, Any] = without_none(msgspec.to_builtins(settings, enc_hook=str))
    return plain


@contextmanager
def _started(command: str, config: Path, log_file: Path) -> Iterator["subprocess.Popen[bytes]"]:
    with log_file.open("wb") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", "ods", command, "--config", str(config)],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
        )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(5.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _wait_ready(
    collector: Collector,
    names: list[str],
    process: "subprocess.Popen[bytes]",
    log_file: Path,
    line: report.ProgressLine,
) -> None:
    deadline_s = time.monotonic() + START_S
    while waiting := [name for name in names if not collector.ready(name)]:
        line.show(f"waiting for {', '.join(waiting)}")
        collector.listen(0.1)
        _still_running(process, log_file)
        if time.monotonic() > deadline_s:
            raise BenchError(f"not ready after {START_S:.0f} s: {', '.join(waiting)}; see {log_file}")


def _still_running(process: "subprocess.Popen[bytes]", log_file: Path) -> None:
    if process.poll() is not None:
        lines = log_file.read_text(errors="replace").strip().splitlines()
        raise BenchError(f"{lines[-1] if lines else 'a process ended'} (see {log_file})")


def _fly(
    collector: Collector,
    settings: BenchConfig,
    onboard: "subprocess.Popen[bytes]",
    simulator: "subprocess.Popen[bytes]",
    line: report.ProgressLine,
) -> None:
    """Listen for the length of the mission, and kill what is to be killed."""
    kills = sorted(settings.kill, key=lambda item: item.at_s)
    begun_s = None
    while begun_s is None or time.monotonic() - begun_s < settings.seconds + AFTER_S:
        collector.listen(0.05)
        if begun_s is None and collector.record.truths:
            begun_s = time.monotonic()
        elapsed_s = time.monotonic() - begun_s if begun_s else 0.0
        while kills and kills[0].at_s <= elapsed_s:
            _kill(kills.pop(0).process, onboard, collector.record)
        _still_running(onboard, settings.out / "run.log")
        _still_running(simulator, settings.out / "sim.log")
        line.show(report.one_line(collector.record, elapsed_s, settings.seconds))
    line.show("")


def _kill(name: str, onboard: "subprocess.Popen[bytes]", record: RunRecord) -> None:
    """Kill -9 one on-board process of this run."""
    for child in psutil.Process(onboard.pid).children():
        if name in child.cmdline():
            record.kills.append((name, clock.monotonic_ns()))
            child.kill()
