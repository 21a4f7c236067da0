"""The weight of a scan as evidence: to a sonar at rest, speckle and crests look as they did before.

Scans are compared, not poses: an echo that is where it was to a few centimetres, and as strong to half a decibel, is
the same one again. Under way it is neither: its speckle is another one after some centimetres.
"""

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.tracker.measurement.scan import Echoes, EchoRows

SAME_RANGE_M, SAME_BEARING_RAD, SAME_DB = 0.05, 0.005, 0.5
"""An echo that differs by less from one of the scan before is the same."""
MOST = 64
"""Of so many echoes of a scan."""
STILL = 0.25
"""Share of such echoes from which on the sonar is at rest: 0.00 to 0.02 under way, 0.54 to 0.98 at rest (simulated)."""
MEMORY = 0.8
"""Share of the sums of echoes that a scan leaves of those before."""
WEIGHT_AT_REST = 0.1
"""Weight of a scan then: only the receiver's noise is another one."""


class Coherence:
    """Compares the echoes of each scan with those of the scan before."""

    def __init__(self) -> None:
        self._before: Floats = np.zeros((len(EchoRows._fields), 0))
        self._same, self._all = 0.0, 0.0

    def weight(self, echoes: Echoes) -> float:
        """Return the weight of a scan: 1 under way, `WEIGHT_AT_REST` at rest."""
        same: int = native.count_same_echoes(echoes.table, self._before, MOST, SAME_RANGE_M, SAME_BEARING_RAD, SAME_DB)
        self._same = MEMORY * self._same + same
        self._all = MEMORY * self._all + min(echoes.table.shape[1], MOST)
        self._before = echoes.table
        return WEIGHT_AT_REST if self._same > STILL * self._all else 1.0
