"""What stands in for devices and processes where the pages of docs/how-to try a new part: a tracker's list, a scan."""

import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import zmq

from ods.base import clock
from ods.messages import ClosestApproach, Obstacle, ObstacleList, PoseAt, Sector
from ods.runtime.bus import Publisher
from ods.tracker.measurement.scan import Scan, echoes_of, vehicle_at
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.tracker import Tracker

CONFIG = Path("ods/config_files/onboard.toml")
PERIOD_S = 0.15
ZERO = (0.0, 0.0, 0.0)
VEHICLE = PoseAt((0.0, 0.0, 20.0), (1.0, 0.0, 0.0, 0.0), ZERO, sigma_position=ZERO, sigma_attitude=ZERO)
ROCK = Obstacle(
    id=7,
    state="active",
    position_ned=(31.5, -2.25, 20.0),
    velocity_ned=ZERO,
    radius_m=1.5,
    sigma_position=(0.1, 0.1, 3.0),
    sigma_velocity=ZERO,
    sigma_radius=0.1,
    first_seen_utc_ns=0,
    last_seen_utc_ns=0,
    times_seen=9,
    existence=1.0,
    cpa=ClosestApproach(time_s=15.0, distance_m=5.5, sigma_m=0.5),
)


@contextmanager
def lists(lines: str = "") -> Iterator[Path]:
    """Publish a valid list with one rock as the tracker does; give the configuration file, which ends with `lines`."""
    over = threading.Event()
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        config = Path(folder) / "onboard.toml"
        config.write_text(CONFIG.read_text().replace("[bus]", f'[bus]\nrun_dir = "{folder}"') + lines)
        tracker = threading.Thread(target=_publish, args=(Path(folder), over))
        tracker.start()
        try:
            yield config
        finally:
            over.set()
            tracker.join()


def _publish(run_dir: Path, over: threading.Event) -> None:
    publisher = Publisher(zmq.Context(), run_dir, "tracker")
    seq = 0
    while not over.wait(PERIOD_S):
        now_ns = clock.monotonic_ns()
        publisher.publish("obstacles", ObstacleList(seq, seq, now_ns, 0, now_ns, True, [], [ROCK], pose=VEHICLE))
        seq += 1
    publisher.close()


@contextmanager
def running(*command: str, lines: str = "") -> Iterator[Path]:
    """Run `ods COMMAND` beside such a tracker; give the run folder. It must end well when it is terminated."""
    with lists(lines) as config:
        process = subprocess.Popen([sys.executable, "-m", "ods", *command, "--config", str(config)])
        try:
            yield config.parent
        finally:
            process.terminate()
            code = process.wait()
        assert code == 0, f"exit code {code}"


def tracked(tracker: Tracker, pings: Iterable[Sequence[float]]) -> Snapshot:
    """Give a static vehicle's tracker pings, each the ranges of objects straight ahead; return its objects."""
    vehicle = vehicle_at(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), np.full(3, 0.05), np.full(3, 0.002))
    assert vehicle is not None
    sector = Sector(
        range_min_m=1.0, range_max_m=100.0, bearing_min_rad=-0.8, bearing_max_rad=0.8, half_vertical_rad=0.2
    )
    for number, ranges_m in enumerate(pings):
        echoes, _ = echoes_of(np.array([[range_m, 0.0, 0.0, 1.0, 0.1, 0.01, 0.3] for range_m in ranges_m]))
        tracker.step(Scan(int(number * PERIOD_S * 1e9), 0, vehicle, sector, echoes))
    return tracker.snapshot()
