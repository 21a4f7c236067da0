"""`ods bench`: the whole chain against the simulated sonar and vehicle, judged by limits and drawn."""

from argparse import Namespace
from pathlib import Path
from typing import Any

import msgspec

from ods.base.frames.mounting import Mounting, mounting_in
from ods.base.settings_file import load
from ods.bench import report
from ods.bench.machine import MachineProbe
from ods.bench.metrics import summarize
from ods.bench.runner import fly_mission
from ods.bench.settings import BenchConfig
from ods.bench.way.avoidance import Mission, judge
from ods.bench.way.best_path import best_path, length_m
from ods.bench.way.path_picture import draw_path
from ods.offline import picture
from ods.plots.style import drawn_in
from ods.sim_sonar.scene.timeline import load_scene
from ods.sim_sonar.steered import SteeredVehicle, at_start


def run(args: Namespace) -> int:
    """Run the bench; return 1 when a limit is broken and a busy computer does not explain it. Raises OdsError."""
    settings = _overridden(load(args.config, BenchConfig), args)
    with MachineProbe() as probe:
        record = fly_mission(settings)
        machine = probe.result()
    steered = steered_mission(settings)
    found = best = None
    if steered is not None:
        best = best_path(steered, record.way[0]) if len(record.way) else None
        found = judge(steered, record.way, record.set_points, None if best is None else length_m(best))
    summary = summarize(record, settings.limits, settings.settle_s, machine, found)
    settings.out.mkdir(parents=True, exist_ok=True)
    (settings.out / "summary.json").write_bytes(msgspec.json.format(msgspec.json.encode(summary)))
    with drawn_in(args.style):
        picture.draw_run(record, settings.out / "scene.png", Mounting(mounting_in(settings.onboard)))
        if steered is not None and len(record.way):
            draw_path(steered, record, best, settings.out / "way.png")
    report.show(summary, settings)
    return 1 if summary.broken else 0


def steered_mission(settings: BenchConfig) -> Mission | None:
    """Return what a steered vehicle had to do, none: it went as the scene says."""
    if settings.planner is None or settings.sim.vehicle is None:
        return None
    still = SteeredVehicle(settings.sim.vehicle.can_do, at_start(0.0, 0.0))
    return Mission(
        load_scene(settings.sim.scene, vehicle=still),
        settings.planner.way_points,
        settings.planner.steering,
        settings.sim.vehicle.can_do,
        settings.sim.vehicle.current_m_s,
        0.0 if settings.limits.avoid is None else settings.limits.avoid.clearance_m,
    )


def _overridden(settings: BenchConfig, args: Namespace) -> BenchConfig:
    """Return the settings with what the command line has in their place."""
    given: dict[str, Path | None] = {"onboard": args.onboard, "out": args.out, "record": args.record}
    changes: dict[str, Any] = {name: path.resolve() for name, path in given.items() if path is not None}
    if args.seconds is not None:
        changes["seconds"] = args.seconds
    if args.scene is not None:
        changes["sim"] = msgspec.structs.replace(settings.sim, scene=args.scene.resolve())
    return msgspec.structs.replace(settings, **changes)
