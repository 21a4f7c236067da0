"""What three vertical planes tell of eight spheres' heights: python -m benchmarks.tracker.planes."""

from collections.abc import Iterator
from typing import NamedTuple

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.messages import Detections
from ods.offline.source import Source, simulated
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseEstimate
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.scene.timeline import Scene
from ods.tracker.measurement.from_detections import received
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

ELEVATIONS_DEG = (-25, -12, -5, 0, 8, 10, 14, 22), (-28, -20, -15, -10, -8, 3, 5, 18)
"""Of the spheres of two scenes; the planes are at -20, 0 and 20 degrees."""
DISTANCE_M = 40.0
DEPTH_M = 50.0
NEAR_M = 5.0
"""A track within this of a sphere, horizontally, is of it: the next sphere is 7 m away or more."""
SECONDS = 8.0
SURFACE = {"cd": 0.1, "cs": 0.05, "sigma_deg": 15.0}


class Seen(NamedTuple):
    """The tracks of one sphere: k of them."""

    elevation_deg: float
    height_error: Floats
    """(k,) in m,"""
    sigma_height: Floats
    """(k,) as reported,"""
    nees: Floats
    """and (k, 2) squared errors over what is reported: of the height, of north and east."""


def places(elevations_deg: tuple[int, ...]) -> Floats:
    """Return the (n, 3) NED places of a scene's spheres."""
    elevation = np.radians(elevations_deg)
    bearing = np.radians(-38.0 + 11.0 * np.arange(len(elevations_deg)))
    level = np.cos(elevation)
    unit = np.column_stack([level * np.cos(bearing), level * np.sin(bearing), -np.sin(elevation)])
    return DISTANCE_M * unit + (0.0, 0.0, DEPTH_M)


def pings_of(elevations_deg: tuple[int, ...], seconds: float) -> Source:
    """Return the simulated pings of spheres of 1 m radius before a vehicle that hovers."""
    spheres = [
        {"shape": "sphere", "name": f"{number}", "position_ned": place, "radius_m": 1.0, "surface": SURFACE}
        for number, place in enumerate(places(elevations_deg).tolist())
    ]
    scene = {
        "seed": 1,
        "duration_s": seconds,
        "shadows": False,
        "vehicle": {"position_ned": [0.0, 0.0, DEPTH_M], "velocity_ned": [0.0, 0.0, 0.0]},
        "objects": spheres,
        "image": {"gain": 20000.0, "noise_counts": 30.0, "looks": 1.0},
    }
    return simulated(Scene(msgspec.convert(scene, SceneFile)), find_sonar("seabat6012_3plane"))


def found_in(source: Source) -> list[Detections]:
    """Return what the chain finds in each ping."""
    chain = Chain(PipelineSettings())
    return [chain.process(source.pings[number]) for number in range(len(source.pings))]


def tracked(found: list[Detections], *, by_plane: bool) -> Snapshot:
    """Return the tracks after the last ping; by_plane False: as if the sector did not tell of its planes."""
    tracker = Tracker(TrackerSettings())
    for message in found:
        sector = message.sector if by_plane else msgspec.structs.replace(message.sector, plane_half_rad=0.0)
        reported = msgspec.structs.replace(message, sector=sector)
        tracker.step(received(reported, hovering(message.t_ns), hovering, message.utc_ns).scan)
    return tracker.snapshot()


def hovering(t_ns: int) -> PoseEstimate:
    """Return the pose at any time."""
    rest = np.zeros(3)
    place, level = np.array([0.0, 0.0, DEPTH_M]), np.array([1.0, 0.0, 0.0, 0.0])
    return PoseEstimate(t_ns, place, level, rest, np.full(3, 0.05), np.full(3, 0.002), 0.0)


def seen_of(tracks: Snapshot, elevations_deg: tuple[int, ...]) -> Iterator[Seen]:
    """Yield what is reported of each sphere."""
    for elevation, place in zip(elevations_deg, places(elevations_deg), strict=True):
        error = tracks.position - place[:, None]
        near = np.hypot(*error[:2]) < NEAR_M
        error, sigma = error[:, near], tracks.sigma_position[:, near]
        nees = np.empty((error.shape[1], 2))
        nees[:, 0] = (error[2] / sigma[2]) ** 2
        for k, mixed in enumerate(tracks.covariance_ne[near]):
            covariance = np.array([[sigma[0, k] ** 2, mixed], [mixed, sigma[1, k] ** 2]])
            nees[k, 1] = error[:2, k] @ np.linalg.solve(covariance, error[:2, k])
        yield Seen(elevation, -error[2], sigma[2], nees)


def main() -> None:
    """Print the table."""
    print("| elevation, deg | tracks | height's error, m | its sigma reported, m | NEES: height; north, east |")
    print("|---|---|---|---|---|")
    for elevations in ELEVATIONS_DEG:
        found = found_in(pings_of(elevations, SECONDS))
        ways = [list(seen_of(tracked(found, by_plane=by_plane), elevations)) for by_plane in (False, True)]
        for rows in zip(*ways, strict=True):
            columns = [", ".join(cells) for cells in zip(*map(_cells, rows), strict=True)]
            print(f"| {rows[0].elevation_deg} | {' | '.join(columns)} |")
        for name, seen in zip(("the stack's", "each plane's"), ways, strict=True):
            nees = np.concatenate([each.nees for each in seen]).mean(axis=0)
            count = sum(len(each.nees) for each in seen)
            print(f"{name} opening: {count} tracks, mean NEES {nees[0]:.2f}; {nees[1]:.2f}")


def _cells(seen: Seen) -> tuple[str, str, str, str]:
    nees = seen.nees.mean(axis=0)
    worst = seen.height_error[np.argmax(np.abs(seen.height_error))]
    return str(len(seen.nees)), f"{worst:+.1f}", f"{seen.sigma_height.max():.1f}", f"{nees[0]:.1f}; {nees[1]:.1f}"


if __name__ == "__main__":
    main()
