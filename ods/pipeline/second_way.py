"""Multipath: all that is heard comes once more by a longer way, over the surface say, and looks like bodies.

Such an echo stands in its body's direction, fainter, and behind all bodies by the same difference of range, which stays
while the vehicle moves. A difference that most loud bodies of most pings show is one; that of a single body may be
another body, and is not told.
"""

import math
from collections.abc import Sequence

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Detection, Ping
from ods.pipeline.image.sample_levels import db_a_count

STEP_M, STEPS = 0.25, 160
"""Differences of range that are looked for: up to 40 m."""
FOLLOW_S = 1.0
"""Time constant by which the share of the pings is followed that show a difference."""
BEGIN, END = 0.5, 0.2
"""Shares from which on a way is told, and until which."""


class SecondWays:
    """Looks at the echoes of ping after ping."""

    def __init__(self) -> None:
        self._votes = np.zeros(STEPS)
        self._told = np.zeros(STEPS, np.bool_)
        self._t_ns = 0

    def of(self, ping: Ping, detections: Sequence[Detection], faint: Sequence[Detection]) -> list[float]:
        """Return by how much longer ways are by which bodies are heard once more, m of range."""
        since_s, self._t_ns = (ping.t_ns - self._t_ns) / NS, ping.t_ns
        a_count = db_a_count(ping)
        echoes = [
            (echo.near_m, echo.bearing_rad, echo.snr_db, _level_db(echo.amplitude, a_count))
            for group in (detections, faint)
            for echo in group
        ]
        weight = float(-np.expm1(-min(max(since_s, 0.0), 1.0) / FOLLOW_S))
        far_m = ping.range0_m + ping.samples * ping.dr_m
        native.vote_for_ways(np.array(echoes).reshape(-1, 4), far_m, STEP_M, weight, self._votes)
        if self._votes.max() <= END:
            self._told[:] = False
            return []
        self._told = self._votes > np.where(self._told, END, BEGIN)
        if not self._told.any():
            return []
        return [_middle(self._votes, run) for run in _runs(np.flatnonzero(self._told))]


def _level_db(amplitude: float, a_count: float) -> float:
    return amplitude * a_count if a_count > 0.0 else 20.0 * math.log10(max(amplitude, 1e-6))


def _runs(steps: Indices) -> list[Indices]:
    """Return the runs of neighbouring steps."""
    return np.split(steps, np.flatnonzero(np.diff(steps) > 1) + 1)


def _middle(votes: Floats, run: Indices) -> float:
    return float(STEP_M * ((run + 1) @ votes[run]) / votes[run].sum())
