"""Bodies that the fan's edge cuts off: are place, speed and size of their tracks as good as they are told to be?

Spheres of 0.5, 1.5 and 3 m cross the borders of the fan of a SeaBat 6012 at 22 to 70 m, in and out, to either side:
moving at 0.3, 0.7 and 1.5 m/s across, or at rest while the vehicle goes ahead or yaws. Simulator, chain and tracker as
they are on board, without sockets and shadows; 26 s a scene, eight spheres each. Counted are the lists while a sphere's
circle is less than a beam's width from the border, or on it. `python -m benchmarks.tracker.fan_edge [--runs N]`.
"""

import argparse
import math
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ods.messages import Obstacle, Truth, TruthObject
from ods.offline.mission import Mission, MissionSettings
from ods.offline.source import simulated
from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.timeline import load_scene

EDGE, BEAM = math.radians(45.0), math.radians(1.5)
RADII_M, RANGES_M = (0.5, 1.5, 3.0), (22.0, 36.0, 52.0, 70.0)
CROSSES_S = 13.0
FARTHEST_M = 6.0
"""A track farther off its body is not its own."""
UNLIKELY = 9.21
"""One error in a hundred is larger, if they are as large as told."""


@dataclass(frozen=True)
class Case:
    """What moves."""

    name: str
    object_speed: float = 0.0
    """m/s, across the line of sight, half of them outwards."""
    vehicle_speed: float = 0.0
    """m/s, ahead."""
    yaw_deg: float = 0.0
    """Amplitude of a yaw with a period of 17 s."""


CASES = (
    *(Case(f"object {v} m/s", object_speed=v) for v in (0.3, 0.7, 1.5)),
    Case("vehicle 1.5 m/s ahead", vehicle_speed=1.5),
    Case("vehicle yaws by 8 deg", yaw_deg=8.0),
)


@dataclass
class Found:
    """Of the bodies of one case, one size and one direction."""

    lists: int = 0
    nees: list[float] = field(default_factory=list)
    off_m: list[float] = field(default_factory=list)
    speed_off: list[float] = field(default_factory=list)
    radius: list[float] = field(default_factory=list)
    """Ratio of the reported to the true value."""


def scene_text(case: Case, seed: int) -> str:
    """Return a scene of eight spheres that cross the border halfway."""
    items, count = [], 0
    for row, range_m in enumerate(RANGES_M):
        for side in (-1, 1):
            radius, outwards = RADII_M[(count + seed) % 3], (row + (side > 0) + seed) % 2 == 0
            count += 1
            across = np.array([-math.sin(EDGE), side * math.cos(EDGE)])
            velocity = case.object_speed * (1.0 if outwards else -1.0) * across
            place = range_m * np.array([math.cos(EDGE), side * math.sin(EDGE)]) - CROSSES_S * velocity
            place[0] += CROSSES_S * case.vehicle_speed
            way = "in" if case.object_speed and not outwards else "out"
            items.append(
                f'[[objects]]\nshape = "sphere"\nname = "{way}/{radius}/{count}"\nradius_m = {radius}\n'
                f"position_ned = [{place[0]}, {place[1]}, 4.0]\nvelocity_ned = [{velocity[0]}, {velocity[1]}, 0.0]\n"
                "surface = { cd = 0.1, cs = 0.05, sigma_deg = 15.0 }\n"
            )
    yaw = f"yaw = {{ amplitude_deg = {case.yaw_deg}, period_s = 17.0 }}\n" if case.yaw_deg else ""
    vehicle = f"[vehicle]\nposition_ned = [0.0, 0.0, 4.0]\nvelocity_ned = [{case.vehicle_speed}, 0.0, 0.0]\n{yaw}"
    image = "[image]\ngain = 20000.0\nnoise_counts = 30.0\nlooks = 1.0\n"
    head = f"seed = {seed}\nduration_s = {2.0 * CROSSES_S}\nshadows = false\n"
    return head + vehicle + "".join(items) + image


def lists_of(text: str) -> Iterator[tuple[Truth, list[Obstacle]]]:
    """Yield what is true of each ping of a scene, and what is listed."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.toml"
        path.write_text(text)
        source = simulated(load_scene(path), find_sonar("seabat6012"))
    pings = (source.pings[k] for k in range(len(source.pings)))
    for step in Mission(MissionSettings()).steps(pings, source.poses):
        listed = [o for o in step.list.obstacles if o.state in ("active", "stand_by")]
        yield source.truths[step.ping.ping_number], listed


def is_on_border(truth: Truth, item: TruthObject) -> bool:
    """Tell whether the border runs through an object or within a beam's width of it."""
    w, x, y, z = truth.attitude
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    north, east = (item.position_ned[k] - truth.position_ned[k] for k in (0, 1))
    half = math.asin(min(item.radius_m / math.hypot(north, east), 1.0))
    return abs(abs(math.atan2(east, north) - yaw) - EDGE) < half + BEAM


def look(item: TruthObject, listed: Sequence[Obstacle], found: Found) -> None:
    """Note how far the nearest track is off."""
    found.lists += 1
    place, velocity = (np.array(v[:2]) for v in (item.position_ned, item.velocity_ned))
    errors: list[NDArray[np.float64]] = [np.array(o.position_ned[:2]) - place for o in listed]
    away = [math.hypot(*error) for error in errors]
    if not away or min(away) > FARTHEST_M:
        return
    k = int(np.argmin(away))
    told, error = listed[k], errors[k]
    (s_n, s_e, _), s_ne = told.sigma_position, told.covariance_ne
    found.nees.append(float(error @ np.linalg.solve([[s_n**2, s_ne], [s_ne, s_e**2]], error)))
    found.off_m.append(away[k])
    found.speed_off.append(math.hypot(*(np.array(told.velocity_ned[:2]) - velocity)))
    found.radius.append(told.radius_m / item.radius_m)


def line(name: str, each: Sequence[Found]) -> str:
    """Return a row of the table."""
    nees, off, speed, radius = (
        np.concatenate([getattr(found, k) for found in each]) for k in ("nees", "off_m", "speed_off", "radius")
    )
    tracked, unlikely = 100.0 * len(nees) / sum(found.lists for found in each), 100.0 * (nees > UNLIKELY).mean()
    rms, speed_rms = math.sqrt((off**2).mean()), math.sqrt((speed**2).mean())
    figures = f"{nees.mean():7.2f} {unlikely:6.1f} % {rms:7.2f} {speed_rms:7.2f} {radius.mean():7.2f}"
    return f"{name:38s} {tracked:5.0f} % {figures}"


def runs_of(doc: str | None) -> int:
    """Return how many scenes a case the command line asks for."""
    parser = argparse.ArgumentParser(description=doc)
    parser.add_argument("--runs", type=int, default=3, help="scenes a case (default: 3)")
    return int(parser.parse_args().runs)


def table_of(scenes: Iterable[tuple[str, str]], counts: Callable[[Truth, TruthObject], bool]) -> dict[str, Found]:
    """Run scenes, (case, text), print a row for each case, way and size, and return them; `counts`: what they hold."""
    found: dict[str, Found] = {}
    for case, text in scenes:
        for truth, listed in lists_of(text):
            for item in truth.objects:
                way, radius, _ = item.name.split("/")
                if counts(truth, item):
                    look(item, listed, found.setdefault(f"{case}, {way}, {radius} m", Found()))
    print(f"{'':38s} tracked    NEES  > {UNLIKELY}   rms m rms m/s  radius")
    for name, one in found.items():
        print(line(name, [one]) if one.nees else f"{name:38s}   never tracked")
    return found


def main() -> None:
    """Run all cases and print the table."""
    runs = runs_of(__doc__)
    found = table_of(((case.name, scene_text(case, seed)) for case in CASES for seed in range(runs)), is_on_border)
    print(line("all", list(found.values())))


if __name__ == "__main__":
    main()
