"""Multipath: every echo arrives again by a longer path, over the surface for example, and looks like an object.

Such an echo stands in its body's direction, fainter, and behind all bodies by the same difference of range, which stays
while the vehicle moves. A difference that most loud bodies of most pings show is one; that of a single body may be
another body, and is not reported. A body counts where its echo by that way is loud enough. What is known
of a way stays while no body can show it, and then one body is enough.
"""

import math

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Ping
from ods.pipeline.measure.echoes import EchoTable

STEP_M, STEPS = 0.25, 160
"""Step, m, and number of the differences of range that are tested: up to 40 m."""
RISE_S, FALL_S, FORGET_S = 0.3, 1.0, 30.0
"""Time constants, s, of the share of pings that show a difference: for a ping that does, which is rarely by chance; for
one that does not, as echoes are missed; and while no object is loud enough to show one that is reported."""
BEGIN, END = 0.5, 0.2
"""Shares at which the report of a path begins and ends."""


class MultipathDetector:
    """Examines the echoes of successive pings."""

    def __init__(self) -> None:
        self._votes = np.zeros(STEPS)
        self._reported = np.zeros(STEPS, np.bool_)
        self._weaker_db = np.zeros(STEPS)
        self._t_ns = 0

    def of(self, ping: Ping, db_a_count: float, echoes: EchoTable, faint: EchoTable, from_db: float) -> list[float]:
        """Return the excess lengths, m of range, of the paths by which objects appear a second time.

        db_a_count: see `SampleScale`; from_db: from how much over the local tail on an echo is received.
        """
        since_s, self._t_ns = (ping.t_ns - self._t_ns) / NS, ping.t_ns
        rise, fall, idle = (-math.expm1(-min(max(since_s, 0.0), 1.0) / each) for each in (RISE_S, FALL_S, FORGET_S))
        far_m = ping.range0_m + ping.samples * ping.dr_m
        most = native.vote_for_ways(
            echoes, faint, db_a_count, far_m, from_db, STEP_M, rise, fall, idle, self._reported,
            self._votes, self._weaker_db,
        )  # fmt: skip
        if most <= END:
            self._reported[:] = False
            return []
        self._reported = self._votes > np.where(self._reported, END, BEGIN)
        return [_middle(self._votes, run) for run in _runs(np.flatnonzero(self._reported)) if run.size]


def _runs(steps: Indices) -> list[Indices]:
    """Return the runs of neighbouring steps."""
    return np.split(steps, np.flatnonzero(np.diff(steps) > 1) + 1)


def _middle(votes: Floats, run: Indices) -> float:
    return float(STEP_M * ((run + 1) @ votes[run]) / votes[run].sum())
