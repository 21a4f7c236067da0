"""What sleeping objects cost: scan steps with none and with 10,000 of them, taken in turn.

Run: python -m benchmarks.hibernated
"""

import time

import numpy as np

from ods.base.clock import NS
from ods.base.frames.geometry import quat_from_euler
from ods.messages import Sector
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.scan import Scan, echoes_of, vehicle_at
from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker

COUNTS = (0, 10_000)
STEPS, WARM_UP = 600, 100
RATE_HZ = 7.0
SPEED = 2.0
SECTOR = Sector(0.0, 100.0, -0.785, 0.785, 0.175)
IN_VIEW, FAR_M = 10, 1000.0


def main() -> None:
    """Print the median time of a scan step for each number of sleeping objects."""
    rng = np.random.default_rng(0)
    places = rng.uniform(FAR_M, 20.0 * FAR_M, (max(COUNTS), 2)) * rng.choice([-1.0, 1.0], (max(COUNTS), 2))
    known = [
        MapObject(i + 1, (north, east, 20.0), (0.1, 0.1, 3.0), 1.0, 0.1, 0.99, 9, 0, 0, 0)
        for i, (north, east) in enumerate(places.tolist())
    ]
    trackers = {count: Tracker(TrackerSettings(), known[:count], first_id=max(COUNTS) + 1) for count in COUNTS}
    spent: dict[int, list[float]] = {count: [] for count in COUNTS}
    for step, scan in enumerate(_scans(rng)):
        for count in COUNTS if step % 2 else COUNTS[::-1]:
            start = time.perf_counter()
            trackers[count].step(scan)
            spent[count].append(time.perf_counter() - start)
    for count, times in spent.items():
        print(f"{count:6d} hibernated objects: {1e3 * float(np.median(times[WARM_UP:])):.3f} ms a scan step")


def _scans(rng: np.random.Generator) -> list[Scan]:
    """Return scans of a vehicle that goes north past objects that stay in its view."""
    sigmas = np.tile([0.1, 0.01, 0.3], (IN_VIEW, 1))
    polar = np.column_stack([rng.uniform(20.0, 90.0, IN_VIEW), rng.uniform(-0.6, 0.6, IN_VIEW)])
    scans = []
    for step in range(STEPS):
        t_ns = round(step / RATE_HZ * NS)
        position = np.array([SPEED * step / RATE_HZ, 0.0, 4.0])
        seen = polar + rng.normal(0.0, [0.1, 0.01], (IN_VIEW, 2))
        echoes, _ = echoes_of(np.column_stack([seen, np.zeros(IN_VIEW), np.ones(IN_VIEW), sigmas]))
        vehicle = vehicle_at(position, quat_from_euler(0.0, 0.0, 0.0), np.zeros(3), np.zeros(3))
        scans.append(Scan(t_ns, t_ns, vehicle, SECTOR, echoes))
    return scans


if __name__ == "__main__":
    main()
