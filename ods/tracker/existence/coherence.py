"""How much of a scan is news: to a sonar at rest, speckle and crests look as they did before.

Scans are compared, not poses: an echo that is where it was to a few centimetres, and as strong to half a decibel, is
the same look again. Under way it is neither: its speckle is another one after some centimetres.
"""

import numpy as np

from ods.base.arrays import Floats
from ods.tracker.measurement.scan import Echoes

SAME = np.array([[0.05], [0.005], [0.5]])
"""m of range, rad and dB: an echo that differs by less from one of the scan before is the same."""
STILL = 0.25
"""Share of such echoes from which on the sonar is at rest: 0.00 to 0.02 under way, 0.54 to 0.98 at rest (simulated)."""
MEMORY = 0.8
"""Share of the sums of echoes that a scan leaves of those before."""
NEWS_AT_REST = 0.1
"""Share of a scan that is news then: the receiver's noise is another one."""


class Coherence:
    """Compares the echoes of each scan with those of the scan before."""

    def __init__(self) -> None:
        self._before = np.zeros((3, 0))
        self._same, self._all = 0.0, 0.0

    def news(self, echoes: Echoes) -> float:
        """Return what share of a scan is news: 1 under way, `NEWS_AT_REST` at rest."""
        rows = echoes.rows
        now = np.array([rows.range_m, rows.bearing, rows.strength])
        now = now[:, np.argsort(now[0])]
        self._same = MEMORY * self._same + _count_same(now, self._before)
        self._all = MEMORY * self._all + now.shape[1]
        self._before = now
        return NEWS_AT_REST if self._same > STILL * self._all else 1.0


def _count_same(now: Floats, before: Floats) -> int:
    """Return how many echoes are as one of the scan before; (3, n) range, bearing and strength by range.

    Only the two nearest in range on either side are looked at: in a crowd a few are missed, and time is linear.
    """
    same, count = np.zeros(now.shape[1], np.bool_), before.shape[1]
    place = np.searchsorted(before[0], now[0])
    for step in range(-2, 2):
        other = place + step
        inside = (other >= 0) & (other < count)
        near = np.abs(now[:, inside] - before[:, other[inside]]) < SAME
        same[inside] |= np.logical_and.reduce(near, axis=0)
    return int(np.count_nonzero(same))
