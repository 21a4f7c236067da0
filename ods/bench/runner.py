"""Starts the simulator and `ods run` as a user would, listens as a planner would."""

import time
from contextlib import ExitStack, closing
from signal import Signals
from typing import NamedTuple

from ods.base import clock
from ods.bench import report
from ods.bench.collector import Collector
from ods.bench.program import BenchError, Program
from ods.bench.run_files import write_configs
from ods.bench.settings import BenchConfig, KillSettings
from ods.offline.run_record import RunRecord
from ods.sim_sonar.device.sonar_line import has_numbers

START_S = 60.0
"""For the next sign of progress."""
PLANNER_DEAD_S = 3.0
"""Time after which a killed planner is started again, s: long enough for the vehicle's watchdog."""
AFTER_S = 1.0
"""Time for the last lists to arrive."""


class _Programs(NamedTuple):
    onboard: Program
    simulator: Program
    planner: Program | None


def fly_mission(settings: BenchConfig) -> RunRecord:
    """Run one mission and return what was seen of it."""
    onboard_file, sim_file = write_configs(settings)
    line = report.ProgressLine()
    with (
        closing(Collector(settings.bus.run_dir, settings.out, numbered=has_numbers(settings.sim))) as collector,
        Program("run", onboard_file, settings.out / "run.log") as onboard,
    ):
        _wait_ready(collector, ["pipeline", "tracker"], onboard, line)
        with ExitStack() as others:
            planner = None
            if settings.planner is not None:
                planner = others.enter_context(Program("planner", sim_file, settings.out / "planner.log"))
                _wait_ready(collector, ["planner"], planner, line)
            simulator = others.enter_context(Program("sim", sim_file, settings.out / "sim.log"))
            _wait_ready(collector, ["sim", "sonar", "nav"], simulator, line)
            _fly(collector, settings, _Programs(onboard, simulator, planner), line)
        return collector.record


def _wait_ready(collector: Collector, names: list[str], program: Program, line: report.ProgressLine) -> None:
    deadline_s, was_busy = time.monotonic() + START_S, [""]
    while waiting := [name for name in names if not collector.ready(name)]:
        busy = [collector.busy(name) for name in waiting]
        if busy != was_busy:
            deadline_s, was_busy = time.monotonic() + START_S, busy
        line.show(f"waiting for {', '.join(waiting)}: {', '.join(filter(None, busy))}".removesuffix(": "))
        collector.listen(0.1)
        program.check()
        if down := collector.down():
            raise BenchError(f"{down} (see {program.log_file})")
        if time.monotonic() > deadline_s:
            raise BenchError(f"not ready after {START_S:.0f} s: {', '.join(waiting)}; see {program.log_file}")


def _fly(collector: Collector, settings: BenchConfig, programs: _Programs, line: report.ProgressLine) -> None:
    """Listen for the length of the mission, or until the vehicle arrives, and kill what is to be killed."""
    kills = sorted(settings.kill, key=lambda item: item.at_s)
    begun_s = None
    while begun_s is None or (time.monotonic() - begun_s < settings.seconds + AFTER_S and not _arrived(collector)):
        collector.listen(0.05)
        if begun_s is None and collector.record.truths:
            begun_s = time.monotonic()
        elapsed_s = time.monotonic() - begun_s if begun_s else 0.0
        while kills and kills[0].at_s <= elapsed_s:
            _kill(kills.pop(0), programs, collector.record)
        for program in filter(None, programs):
            program.check()
        line.show(report.state_line(collector.record, elapsed_s, settings.seconds))
    line.show("")


def _kill(kill: KillSettings, programs: _Programs, record: RunRecord) -> None:
    """Send a signal to one process of this run. Of those on board `ods run` takes care, of the planner the bench."""
    if kill.process == "planner" and programs.planner is not None:
        record.kills.append((kill.process, clock.monotonic_ns()))
        programs.planner.restart(PLANNER_DEAD_S)
    for child in programs.onboard.children(kill.process):
        record.kills.append((kill.process, clock.monotonic_ns()))
        child.send_signal(Signals[f"SIG{kill.signal}"])


def _arrived(collector: Collector) -> bool:
    set_points = collector.record.set_points
    return bool(len(set_points)) and set_points[-1].arrived
