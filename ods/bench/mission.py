"""`ods bench`: the whole chain against the simulated sonar and vehicle, judged by limits and drawn."""

from argparse import Namespace
from pathlib import Path
from typing import Any

import msgspec

from ods.base.mounting import Mounting, mounting_in
from ods.base.settings_file import load
from ods.bench import report
from ods.bench.machine import MachineProbe
from ods.bench.metrics import summarize
from ods.bench.runner import fly_mission
from ods.bench.settings import BenchConfig
from ods.offline import picture
from ods.plots.style import drawn_in


def run(args: Namespace) -> int:
    """Run the bench; return 1 when a limit is broken and a busy computer does not explain it. Raises OdsError."""
    settings = _overridden(load(args.config, BenchConfig), args.seconds, args.out, args.record)
    with MachineProbe() as probe:
        record = fly_mission(settings)
        machine = probe.result()
    summary = summarize(record, settings.limits, settings.settle_s, machine)
    settings.out.mkdir(parents=True, exist_ok=True)
    (settings.out / "summary.json").write_bytes(msgspec.json.format(msgspec.json.encode(summary)))
    with drawn_in(args.style):
        picture.draw_run(record, settings.out / "scene.png", Mounting(mounting_in(settings.onboard)))
    report.show(summary, settings)
    return 1 if summary.broken else 0


def _overridden(settings: BenchConfig, seconds: float | None, out: Path | None, record: Path | None) -> BenchConfig:
    changes: dict[str, Any] = {}
    if seconds is not None:
        changes["seconds"] = seconds
    if out is not None:
        changes["out"] = out.resolve()
    if record is not None:
        changes["record"] = record.resolve()
    return msgspec.structs.replace(settings, **changes)
