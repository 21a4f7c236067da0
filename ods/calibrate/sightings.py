"""Detections of the one fixed object in a recording: the place where most pings agree."""

from collections.abc import Iterable

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.base.clock import NS
from ods.calibrate.model import Echoes, HeadPoses, Parameters, measurement_residuals, places
from ods.messages import Detections

STRONGEST = 6
"""Detections of a ping that are looked at."""
TRIAL_YAWS_DEG = range(-20, 21, 2)
"""By which the configured yaw may be wrong."""
CELL_M = 3.0
FIRST_REACH_M = 6.0
"""Around the place where most pings agree."""
REACH_M, REACH_RAD = 1.5, 0.05
"""Around the range and bearing that a fit expects."""


def echoes_of(messages: Iterable[Detections], begin_ns: int) -> Echoes:
    """Return the strongest detections of all pings; time 0 is `begin_ns`, by the clock of the messages' `t_ns`."""
    rows = [
        (
            *(index, (message.t_ns - begin_ns) / NS, d.range_m, d.bearing_rad, d.elevation_rad, d.snr_db),
            *(max(d.sigma_range_m, 1e-3), max(d.sigma_bearing_rad, 1e-4), message.sound_speed),
        )
        for index, message in enumerate(messages)
        for d in sorted(message.detections, key=lambda d: -d.snr_db)[:STRONGEST]
    ]
    ping, *others = np.array(rows, np.float64).reshape(-1, 9).T
    return Echoes(ping.astype(np.int64), *others)


def first_guess(echoes: Echoes, head_poses: HeadPoses) -> tuple[Indices, Parameters]:
    """Return the echoes, one a ping, at the place where most pings agree, and that place."""
    best, yaw, centre, where = -1, 0.0, np.zeros(3), np.zeros((0, 3))
    pitch = float(np.radians(head_poses.mounting.pitch_deg))
    for trial in TRIAL_YAWS_DEG:
        tried = float(np.radians(head_poses.mounting.yaw_deg + trial))
        found = places(echoes, head_poses, tried, pitch)
        for shift in (0.0, 0.5):
            count, middle = _fullest_cell(found, echoes.ping, shift)
            if count > best:
                best, yaw, centre, where = count, tried, middle, found
    near = np.flatnonzero(np.hypot(*(where - centre)[:, :2].T) <= FIRST_REACH_M)
    chosen = _one_a_ping(echoes, near, -echoes.snr_db[near])
    north, east, down = np.median(where[chosen], axis=0).tolist()
    return chosen, Parameters(north, east, down, yaw, pitch, 0.0, 0.0)


def as_expected(echoes: Echoes, head_poses: HeadPoses, fitted: Parameters) -> Indices:
    """Return the echoes, one a ping, that are where a fit expects the object."""
    along, across = measurement_residuals(echoes, head_poses, fitted)
    off = np.hypot(along / REACH_M, across / REACH_RAD)
    near = np.flatnonzero(off <= 1.0)
    return _one_a_ping(echoes, near, off[near])


def _fullest_cell(found: Floats, ping: Indices, shift: float) -> tuple[int, Floats]:
    """Return how many pings have an echo in the cell in which most have one, and the middle of those echoes."""
    cells = np.floor(found[:, :2] / CELL_M + shift).astype(np.int64)
    once = np.unique(np.column_stack([ping, cells]), axis=0)[:, 1:]
    kinds, counts = np.unique(once, axis=0, return_counts=True)
    most = int(counts.argmax())
    return int(counts[most]), np.median(found[(cells == kinds[most]).all(axis=1)], axis=0)


def _one_a_ping(echoes: Echoes, which: Indices, cost: Floats) -> Indices:
    """Return of some echoes the one of least cost of each ping, in order of pings."""
    order = np.lexsort([cost, echoes.ping[which]])
    _, first = np.unique(echoes.ping[which][order], return_index=True)
    return np.asarray(which[order][first])
