"""The tracks of a run as arrays: what `ods track --out` writes. Format in docs/recordings/tracks.md."""

from pathlib import Path

import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.files.out_file import opened_to_seek
from ods.messages import ObstacleList
from ods.offline.mission import Step
from ods.tracker.output.obstacle_list import NAMES

STATUS = {name: state for state, name in NAMES.items()}


class TracksFile:
    """Collects the tracks of a run."""

    def __init__(self) -> None:
        self._rows: list[list[float]] = []
        self._pings: list[tuple[int, float, float, float]] = []

    def add(self, step: Step) -> None:
        """Take the list of one ping in."""
        self._rows += rows_of_list(len(self._pings), step.list)
        self._pings.append((step.ping.ping_number, step.ping.t_ns / NS, step.tracker_ms, step.chain_ms))

    def save(self, path: Path) -> None:
        """Write the file. Raises OSError."""
        number, t, wall_ms, chain_ms = np.array(self._pings, np.float64).reshape(-1, 4).T
        trk: Floats = np.array(self._rows, np.float64).reshape(-1, 8)
        with opened_to_seek(path) as file:
            np.savez_compressed(
                file, trk=trk, wall_ms=wall_ms, chain_ms=chain_ms, t=t, ping_number=number.astype(np.int64)
            )


def rows_of_list(scan: int, obstacles: ObstacleList) -> list[list[float]]:
    """Return the rows of `trk` for a list; what is terminated has none."""
    return [
        [scan, o.id, *o.position_ned[:2], *o.velocity_ned[:2], o.radius_m, STATUS[o.state]]
        for o in obstacles.obstacles
        if o.state != "terminated"
    ]
