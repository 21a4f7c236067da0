"""Multipath: all that is heard comes once more by a longer way, over the surface say, and looks like bodies.

Such an echo stands in its body's direction, fainter, and behind all bodies by the same difference of range, which stays
while the vehicle moves. A difference that most loud bodies of most pings show is one; that of a single body may be
another body, and is not reported. A body counts where its echo by that way is strong enough to be heard. What is known
of a way stays while no body can show it, and then one body is enough.
"""

import math

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Ping
from ods.pipeline.image.sample_levels import db_a_count
from ods.pipeline.measure.echoes import EchoTable

STEP_M, STEPS = 0.25, 160
"""Differences of range that are looked for: up to 40 m."""
RISE_S, FALL_S, FORGET_S = 0.3, 1.0, 30.0
"""Time constants by which the share of the pings is followed that show a difference: of one that does, which is rarely
by chance; of one that does not, as echoes are missed; and while no body is loud enough to show one that is told."""
BEGIN, END = 0.5, 0.2
"""Shares from which on a way is told, and until which."""


class SecondWays:
    """Looks at the echoes of ping after ping."""

    def __init__(self) -> None:
        self._votes = np.zeros(STEPS)
        self._told = np.zeros(STEPS, np.bool_)
        self._weaker_db = np.zeros(STEPS)
        self._t_ns = 0

    def of(self, ping: Ping, echoes: EchoTable, faint: EchoTable, from_db: float) -> list[float]:
        """Return by how much longer ways are by which bodies are heard once more, m of range.

        from_db: from how much over the local tail on an echo is heard.
        """
        since_s, self._t_ns = (ping.t_ns - self._t_ns) / NS, ping.t_ns
        rise, fall, idle = (-math.expm1(-min(max(since_s, 0.0), 1.0) / each) for each in (RISE_S, FALL_S, FORGET_S))
        far_m = ping.range0_m + ping.samples * ping.dr_m
        most = native.vote_for_ways(
            echoes, faint, db_a_count(ping), far_m, from_db, STEP_M, rise, fall, idle, self._told,
            self._votes, self._weaker_db,
        )  # fmt: skip
        if most <= END:
            self._told[:] = False
            return []
        self._told = self._votes > np.where(self._told, END, BEGIN)
        return [_middle(self._votes, run) for run in _runs(np.flatnonzero(self._told)) if run.size]


def _runs(steps: Indices) -> list[Indices]:
    """Return the runs of neighbouring steps."""
    return np.split(steps, np.flatnonzero(np.diff(steps) > 1) + 1)


def _middle(votes: Floats, run: Indices) -> float:
    return float(STEP_M * ((run + 1) @ votes[run]) / votes[run].sum())
