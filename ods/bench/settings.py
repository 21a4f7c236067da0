"""Settings of the bench: config/bench.toml."""

from pathlib import Path
from typing import Annotated, Literal

import msgspec

from ods.base.settings import Fraction, NonNegative, NonNegativeInt, Positive, Settings
from ods.planner.settings import PlannerSettings
from ods.sim_sonar.settings import SimConfig


class KillSettings(Settings, frozen=True):
    """A signal sent to a process."""

    process: Literal["sonar", "pipeline", "tracker", "nav", "planner"]
    at_s: NonNegative
    """Mission time."""
    signal: Literal["KILL", "STOP"] = "KILL"
    """STOP: the process hangs until it is killed; not for the planner."""

    def __post_init__(self) -> None:
        if (self.process, self.signal) == ("planner", "STOP"):
            raise ValueError("signal: the planner can only be killed")


class AvoidLimits(Settings, frozen=True):
    """With a planner; a collision always fails, as does not reaching the goal."""

    clearance_m: NonNegative
    """From the vehicle's circle to any object."""
    path_ratio: Annotated[float, msgspec.Meta(ge=1.0)]
    """Path length relative to that of an all-knowing planner."""
    over_bottom_m: NonNegative = 0.0


class BenchLimits(Settings, frozen=True):
    """Beyond a limit `ods bench` exits with code 1. None: not judged."""

    pings_lost: NonNegativeInt
    """Without an obstacle list."""
    latency_p50_ms: Positive
    """From the ping's last byte to its list at the client."""
    latency_p99_ms: Positive
    longest_gap_s: Positive
    """Between two obstacle lists."""
    position_rms_m: Positive | None = None
    """Horizontal, over all lists and objects."""
    radius_error: Fraction | None = None
    """Mean relative error of each object."""
    tracked_share: Fraction | None = None
    """Of the lists, with a track of each object, once `settle_s` in the sector."""
    false_tracks: NonNegativeInt | None = None
    """Confirmed tracks without an object."""
    avoid: AvoidLimits | None = None
    back_within_s: Positive = 3.0
    """From a kill to the next health report."""


class BenchConfig(SimConfig, frozen=True):
    """A bench run: the simulation, the configuration under test, and the limits."""

    seconds: Positive
    """Length of the mission."""
    out: Path
    """Folder of the results."""
    limits: BenchLimits
    planner: PlannerSettings | None = None
    """None: no planner; the simulated vehicle then goes as the scene says."""
    settle_s: NonNegative = 3.0
    """Time from an object's entry into the sector by which it must be tracked."""
    record: Path | None = None
    """Record everything on the bus, truth too, into a new folder in this one."""
    kill: list[KillSettings] = msgspec.field(default_factory=list)

    def __post_init__(self) -> None:
        steered = {"planner": self.planner, "sim.vehicle": self.sim.vehicle, "limits.avoid": self.limits.avoid}
        missing = [key for key, value in steered.items() if value is None]
        if missing and len(missing) < len(steered):
            raise ValueError(f"{missing[0]}: missing; planner, sim.vehicle and limits.avoid belong together")
        if self.planner is None and any(each.process == "planner" for each in self.kill):
            raise ValueError("kill: there is no planner")
        if self.planner is not None and self.planner.can is None:
            raise ValueError("planner.can: missing: the simulated vehicle receives set points on CAN")
