"""What a vehicle's bus reports of operators' vetoes and of bridges, in words."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from ods.base.clock import NS
from ods.messages import Health, ObstacleList, VetoRegion
from ods.runtime.processes import PROCESSES
from ods.workbench.engine.live import state_of

BRIDGE = "bridge_"


class HeldVeto(NamedTuple):
    """A veto that holds."""

    number: int
    what: str
    """That it names."""
    ignored: list[int]
    """Ids of the obstacles that are ignored by it now."""
    author: str
    reason: str
    left_s: float
    """Until it expires."""
    until_utc_ns: int


class Bridge(NamedTuple):
    """A bridge that runs."""

    name: str
    """As in `[bridge.NAME]`."""
    does: str
    state: str
    bad: bool
    sent: int
    """Lists since its start."""
    withheld: int
    """Lists that were not valid."""
    left_out: int
    """Obstacles that were ignored, or for which its messages have no place."""


def vetoes(reported: ObstacleList) -> list[HeldVeto]:
    """Return the vetoes of a list, in its order."""
    ids: dict[int, list[int]] = {}
    for each in reported.obstacles:
        ids.setdefault(each.ignored_by, []).append(each.id)
    return [
        HeldVeto(
            veto.number, named(veto.id, veto.region), ids.get(veto.number, []), veto.author, veto.reason,
            (veto.until_ns - reported.t_ns) / NS, veto.until_utc_ns,
        )
        for veto in reported.vetoes
    ]  # fmt: skip


def named(identity: int | None, region: VetoRegion) -> str:
    """Return what a veto names."""
    if region.centre_ne is not None:
        north, east = region.centre_ne
        place = f"{region.radius_m:.1f} m around {north:.1f} north, {east:.1f} east"
    else:
        place = f"a polygon of {len(region.corners_ne)} corners"
    depth = "" if region.down_m is None else f", {region.down_m[0]:.1f} to {region.down_m[1]:.1f} m down"
    what = "what rests within" if identity is None else f"obstacle {identity}, while it is within"
    return f"{what} {place}{depth}"


def bridges(health: Mapping[str, Health], age_s: Callable[[str], float | None]) -> list[Bridge]:
    """Return the bridges that have reported; age_s: of a process's newest word."""
    found = []
    for name, process in PROCESSES.items():
        report = health.get(name)
        if name.startswith(BRIDGE) and report is not None:
            state, bad = state_of(report, age_s(name))
            counts = (report.counters.get(each, 0) for each in ("sent_lists", "withheld_lists", "left_out_obstacles"))
            found.append(Bridge(name.removeprefix(BRIDGE), process.job, state, bad, *counts))
    return found
