"""`python -m benchmarks.missions`: CPU time of a mission in the loop beside `ods track` on the same way.

All go through the same world and take turns of some pings, so that a busy machine slows all of them alike.
"""

import argparse
import time
from collections.abc import Callable, Iterator
from itertools import islice, pairwise

import msgspec
from rich.console import Console
from rich.table import Table

from ods.missions.flight import Flight
from ods.missions.settings import Campaign, WorldSettings
from ods.offline.mission import Mission, MissionSettings
from ods.offline.source import Source, simulated
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.echo.surface.settings import Surface
from ods.sim_sonar.scene.settings import VehiclePath, Waypoint
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.sea_bed.settings import Roughness, SeaBed
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.steered import VehicleState

BED = SeaBed(
    depth_m=27.0, surface=Surface(cd=0.5, cs=0.2, sigma_deg=20.0), rough=Roughness(rms_height_m=0.15, correlation_m=3.0)
)
WORLDS = {"open water": WorldSettings(), "rough bottom": WorldSettings(sea_bed=BED)}
TURN = 20
"""Pings."""


def main() -> None:
    """Print a table a world."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sonar", default="seabat6012")
    parser.add_argument("--pings", type=int, default=600)
    args = parser.parse_args()
    sonar = find_sonar(args.sonar)
    for name, settings in WORLDS.items():
        jobs = jobs_of(settings, sonar, args.pings)
        spent = taken_in_turns(jobs, args.pings)
        table = Table("", "ms a ping", "times faster than real time", title=f"{name}, {sonar.name}, CPU time")
        for job, seconds in spent.items():
            each = seconds / args.pings
            table.add_row(job, f"{1e3 * each:.2f}", f"{sonar.ping_period_s / each:.1f}")
        Console().print(table)


def jobs_of(settings: WorldSettings, sonar: SonarModel, pings: int) -> dict[str, Iterator[object]]:
    """Return what is measured; one step of each is a ping."""
    campaign = Campaign(seed=1, world=settings)
    flown = Flight(campaign, 0, "truth", sonar, MissionSettings())
    for ping in range(pings + 1):
        flown.step(ping)
    source = along(flown, flown.vehicle.way, sonar)
    images = along(flown, flown.vehicle.way, sonar)
    truth = Flight(campaign, 0, "truth", sonar, MissionSettings())
    mission = Flight(campaign, 0, "ods", sonar, MissionSettings())
    return {
        "mission, the ODS list": steps_of(mission.step),
        "ods track SCENE on the same way": Mission(MissionSettings()).steps(source.pings, source.poses),
        "images alone": steps_of(lambda ping: images.pings[ping]),
        "mission, the truth as list": steps_of(truth.step),
    }


def along(flown: Flight, way: list[VehicleState], sonar: SonarModel) -> Source:
    """Return the world of a mission as a scene in which the vehicle goes the same way."""
    points = [Waypoint(t_s=state.t_s, position_ned=state.place) for state in way[::20]]
    file = flown.world.scene(points[-1].t_s)
    scene = msgspec.structs.replace(file, vehicle=VehiclePath(waypoints=points, follow_path=True))
    return simulated(Scene(scene), sonar)


def steps_of(step: Callable[[int], object]) -> Iterator[object]:
    """Yield the results of a call for ping 0, 1, ..."""
    return map(step, iter(range(10**9)))


def taken_in_turns(jobs: dict[str, Iterator[object]], pings: int) -> dict[str, float]:
    """Return the CPU time of so many pings of each job, s."""
    spent = dict.fromkeys(jobs, 0.0)
    for _ in pairwise(range(0, pings + TURN, TURN)):
        for name, job in jobs.items():
            began = time.process_time()
            for _ in islice(job, TURN):
                pass
            spent[name] += time.process_time() - began
    return spent


if __name__ == "__main__":
    main()
