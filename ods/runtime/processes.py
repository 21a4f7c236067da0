"""The one process table, read by the supervisor, the `ods` command, the deploy/ units' test and the docs."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Process:
    """One row of the process table."""

    name: str
    job: str
    reads: tuple[str, ...]
    """Topics."""
    publishes: tuple[str, ...]
    """Topics."""
    worker: str
    """`module:class` of its `ods.runtime.service.Worker`."""
    settings: str
    """`module:struct` of the tables that the worker reads of the configuration."""
    config: str = "ods.config:OnboardConfig"
    """`module:struct` of its configuration file."""
    on_board: bool = True
    watches: tuple[str, ...] = ()
    """Processes whose health it reads."""
    answers: str = ""
    """Name of its socket for requests; '': it takes none."""
    raw: bool = False
    """It gets messages as the bytes that they are on the wire."""
    by_configuration: bool = False
    """It runs only where the configuration says so: `[record] on = true`, `[[bus.listen]]`, a table `[bridge.NAME]`."""

    @property
    def command(self) -> str:
        """What runs it behind `ods`: "bridge json" of `bridge_json`."""
        return self.name.replace("_", " ")


SUPERVISOR = "run"
"""Name of the socket on which `ods run` reports the health of processes that are down."""

PROCESSES: dict[str, Process] = {
    process.name: process
    for process in (
        Process(
            "record", "everything on the bus to files",
            reads=(
                "ping", "pose", "detections", "obstacles", "clearance", "truth", "vehicle", "set-point", "raw",
                "sonar-requests", "sonar-answers", "veto-orders",
            ),
            publishes=(),
            worker="ods.recording.service:RecordWorker", settings="ods.recording.settings:RecordConfig",
            watches=("record", "nav", "tracker", "pipeline", "sonar", "sim"), raw=True, by_configuration=True,
        ),
        Process(
            "listen", "topics for other computers, by tcp with keys", reads=(), publishes=(),
            worker="ods.listen.service:ListenWorker", settings="ods.listen.settings:ListenConfig",
            by_configuration=True,
        ),
        Process(
            "bridge_json", "obstacles as JSON, over UDP", reads=("obstacles",), publishes=(),
            worker="ods.bridge.service:JsonWorker", settings="ods.bridge.settings:BridgeConfig",
            by_configuration=True,
        ),
        Process(
            "bridge_ttm", "obstacles as NMEA TTM, over UDP", reads=("obstacles",), publishes=(),
            worker="ods.bridge.service:TtmWorker", settings="ods.bridge.settings:BridgeConfig",
            by_configuration=True,
        ),
        Process(
            "bridge_moos", "obstacles to MOOS-IvP, over UDP", reads=("obstacles",), publishes=(),
            worker="ods.bridge.service:MoosWorker", settings="ods.bridge.settings:BridgeConfig",
            by_configuration=True,
        ),
        Process(
            "bridge_ros2", "obstacles, clear water and images to ROS 2, by DDS",
            reads=("obstacles", "clearance", "ping"), publishes=(),
            worker="ods.bridge.ros2.service:Ros2Worker", settings="ods.bridge.settings:BridgeConfig",
            by_configuration=True,
        ),
        Process(
            "bridge_mavlink", "obstacles as MAVLink, over UDP", reads=("obstacles", "clearance"), publishes=(),
            worker="ods.bridge.service:MavlinkWorker", settings="ods.bridge.settings:BridgeConfig",
            by_configuration=True,
        ),
        Process(
            "planner", "obstacles to set points of the simulated vehicle", reads=("obstacles", "clearance"),
            publishes=("set-point",), on_board=False,
            worker="ods.planner.service:PlannerWorker", settings="ods.planner.settings:PlannerConfig",
            config="ods.bench.settings:BenchConfig",
        ),
        Process(
            "nav", "CAN frames to poses", reads=(), publishes=("pose",),
            worker="ods.nav_bridge.service:NavWorker", settings="ods.nav_bridge.settings:NavConfig",
        ),
        Process(
            "tracker", "detections and pose to obstacles", reads=("detections", "pose"),
            publishes=("obstacles", "clearance", "veto-orders"),
            worker="ods.tracker.service:TrackerWorker", settings="ods.tracker.settings:TrackerProcessConfig",
            watches=("sonar", "pipeline", "nav"),
        ),
        Process(
            "pipeline", "pings to detections", reads=("ping", "pose"), publishes=("detections",),
            worker="ods.pipeline.service:PipelineWorker", settings="ods.pipeline.settings:PipelineConfig",
        ),
        Process(
            "sonar", "sonar bytes to pings", reads=(), publishes=("ping", "raw", "sonar-requests", "sonar-answers"),
            worker="ods.sonar_link.service:SonarWorker", settings="ods.sonar_link.settings:SonarConfig",
            answers="sonar-requests",
        ),
        Process(
            "sim", "simulated sonar and vehicle", reads=(), publishes=("truth", "vehicle"), on_board=False,
            worker="ods.sim_sonar.service:SimWorker", settings="ods.sim_sonar.settings:SimConfig",
            config="ods.bench.settings:BenchConfig",
        ),
    )
}  # fmt: skip
"""In starting order: consumers before producers, so that the first ping finds its readers."""


def on_board() -> list[Process]:
    """Return the processes that `ods run` keeps up, whatever the configuration says."""
    return [process for process in PROCESSES.values() if process.on_board and not process.by_configuration]


def may_be_on_board() -> list[Process]:
    """Return those, and the ones that run where the configuration says so."""
    return [process for process in PROCESSES.values() if process.on_board]
