"""The one process table, read by the supervisor, the `ods` command, the deploy/ units' test and the docs."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Process:
    """One row of the process table."""

    name: str
    worker: str
    """`module:class` of its `ods.runtime.service.Worker`."""
    settings: str
    """`module:struct` of its configuration file."""
    reads: tuple[str, ...]
    """Topics."""
    publishes: tuple[str, ...]
    """Topics."""
    job: str
    on_board: bool = True
    watches: tuple[str, ...] = ()
    """Processes whose health it reads."""
    answers: str = ""
    """Name of its socket for requests; '': it takes none."""


_ONBOARD = "ods.config:OnboardConfig"

PROCESSES: dict[str, Process] = {
    process.name: process
    for process in (
        Process("nav", "ods.nav_bridge.service:NavWorker", _ONBOARD, (), ("pose",), "CAN frames to poses"),
        Process("tracker", "ods.tracker.service:TrackerWorker", _ONBOARD, ("detections", "pose"), ("obstacles",),
                "detections and pose to obstacles", watches=("sonar", "pipeline", "nav")),
        Process("pipeline", "ods.pipeline.service:PipelineWorker", _ONBOARD, ("ping", "pose"), ("detections",),
                "pings to detections"),
        Process("sonar", "ods.sonar_link.service:SonarWorker", _ONBOARD, (), ("ping",), "sonar bytes to pings",
                answers="sonar-requests"),
        Process("sim", "ods.sim_sonar.service:SimWorker", "ods.bench.settings:BenchConfig", (), ("truth",),
                "simulated sonar and vehicle", on_board=False),
    )
}  # fmt: skip
"""In starting order: consumers before producers, so that the first ping finds its readers."""


def on_board() -> list[Process]:
    """Return the processes that `ods run` keeps up."""
    return [process for process in PROCESSES.values() if process.on_board]
