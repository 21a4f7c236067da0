"""The configurations of one bench run, in its results folder."""

from pathlib import Path
from typing import Any

import msgspec
import tomli_w

from ods.base.errors import reason_of
from ods.base.settings import Settings
from ods.base.settings_file import load
from ods.bench.program import BenchError
from ods.bench.settings import BenchConfig
from ods.config import OnboardConfig
from ods.sim_sonar.device.lines.tcp_line import HOST
from ods.sim_sonar.device.sonar_line import port_of
from ods.sim_sonar.ins.can_bus import can_of, planner_can_of
from ods.sim_sonar.ins.nmea_ins import PORT


def write_configs(settings: BenchConfig) -> tuple[Path, Path]:
    """Write the on-board configuration and the bench's, complete and absolute; return where they are.

    Raises OdsError.
    """
    try:
        return _written(settings)
    except OSError as error:
        raise BenchError(f"{settings.out}: {reason_of(error)}: --out names another folder") from error


def _written(settings: BenchConfig) -> tuple[Path, Path]:
    """Raises OSError and OdsError."""
    run_dir = settings.bus.run_dir
    settings.out.mkdir(parents=True, exist_ok=True)
    for old in settings.out.glob("map.sqlite*"):
        old.unlink()
    interface, channel = can_of(settings.sim.can, run_dir)
    onboard = _as_dict(load(settings.onboard, OnboardConfig))
    onboard["bus"]["run_dir"] = str(run_dir)
    onboard["sonar"] |= {"port": port_of(settings.sim, run_dir), "latency_ms": settings.sim.sonar_latency_ms}
    onboard["sonar"]["norbit"]["command_port"] = settings.sim.sonar_command_port
    if settings.sim.sonar_line == "sonar3d15":
        onboard["sonar"]["sonar3d15"] |= {"interface": HOST, "sender": HOST}
    onboard["nav"]["can"] |= {"interface": interface, "channel": channel}
    if settings.sim.ins == "nmea":
        onboard["nav"]["nmea"]["port"] = str(run_dir / PORT)
    onboard["tracker"]["map"]["path"] = str(settings.out / "map.sqlite")
    if settings.record:
        onboard["record"] |= {"on": True, "folder": str(settings.record)}
    bench = _as_dict(settings)
    if "planner" in bench:
        interface, channel = planner_can_of(settings.sim.can, run_dir)
        bench["planner"]["can"] |= {"interface": interface, "channel": channel}
    files = settings.out / "onboard.toml", settings.out / "bench.toml"
    for file, content in zip(files, (onboard, bench), strict=True):
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
