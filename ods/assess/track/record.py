"""Record of a tracker's run: the same arrays for ours, the reference and a library's."""

import time
from dataclasses import dataclass

import numpy as np

from ods.base.arrays import Floats
from ods.tracker import scenario
from ods.tracker.scenario import Scenario
from ods.tracker.settings import TrackerSettings

SCAN, ID, NORTH_M, EAST_M, STATUS = 0, 1, 2, 3, 7
"""Columns of `Record.trk`."""


@dataclass(frozen=True)
class Record:
    """The tracks of one run over K scans."""

    trk: Floats
    """(P, 8) as `ods track` writes it."""
    spread: Floats
    """(P, 3) variances of north and east and their covariance, m^2; nan where the tracker does not report them."""
    cpu_ms: Floats
    """(K,) CPU time of each step."""


def run_tracker(case: Scenario, settings: TrackerSettings) -> Record:
    """Run our tracker over a scenario, as `ods track` does."""
    tracker = scenario.tracker_for(case, settings)
    rows, spreads, cpu_ms = [np.zeros((0, 8))], [np.zeros((0, 3))], []
    for k, scan in enumerate(scenario.scans(case)):
        start = time.process_time()
        tracker.step(scan)
        cpu_ms.append(1e3 * (time.process_time() - start))
        snapshot = tracker.snapshot()
        rows.append(scenario.rows_of(k, snapshot))
        variance = snapshot.sigma_position[:2] ** 2
        spreads.append(np.column_stack([*variance, snapshot.covariance_ne]))
    return Record(np.concatenate(rows), np.concatenate(spreads), np.array(cpu_ms))
