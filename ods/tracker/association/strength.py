"""How strong the echoes of nothing are: a body among the highlights of a bottom is told by what it has over them.

A rough bottom shows its highlights again and again, each in its place, so that they come back as a body does. But there
are many of them, of strengths that are alike, and a body is one of few. So the strengths of the echoes that no
confirmed object explains are counted, by range, and an object's mean strength is held against theirs: once, not for
each echo, as a highlight that is stronger than others stays so.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled import native
from ods.messages import Sector
from ods.tracker.measurement.scan import Echoes
from ods.tracker.named import Named
from ods.tracker.state import StrengthState

RANGES = 10
"""Classes of range that are counted apart."""
MEMORY = 0.98
"""What an image leaves of the counts of those before: they are of the last 7 s at 6.7 images a second."""
POOLED = 10.0
"""The strengths in all ranges count for so many echoes in each."""
FEW = 10.0
"""So many echoes tell half of what there is to know."""
LASTING = 0.4
"""Part of the variance that is one of places, and does not average away over the images."""
SPAN_DB = 20.0
"""Bodies are of any strength within so wide a span."""
MOST = 7.0
"""Largest logarithm of a likelihood ratio that strength alone gives."""
LAW = np.array([LASTING, SPAN_DB, MOST])
"""For C: `StrengthLaw`."""
COUNT, SQUARES = 0, 2
"""Rows of the counts; between them, sums of the strengths."""


class Typical(NamedTuple):
    """The echoes of nothing, at n places: (n,) each."""

    mean_db: Floats
    sigma_db: Floats
    known: Floats
    """How much is known of them, from 0 to 1."""


class Strength:
    """Sums over the echoes of the last images that no confirmed object explains."""

    def __init__(self) -> None:
        self._rings = np.zeros((3, RANGES))
        self._images, self._echoes = 0.0, 0.0

    @property
    def per_scan(self) -> float:
        """Echoes in an image, as far as it is known."""
        return self._echoes / max(self._images, 1.0)

    def state(self) -> StrengthState:
        """Return what was counted."""
        return StrengthState(self._rings.ravel().tolist(), self._images)

    def restore(self, state: StrengthState) -> None:
        """Go on with what another one counted. Raises ValueError."""
        rings = np.array(state.rings, np.float64).reshape(self._rings.shape)
        counts = np.array([*rings[[COUNT, SQUARES]].ravel(), state.images])
        if not (np.isfinite(rings).all() and np.isfinite(counts).all() and (counts >= 0.0).all()):
            raise ValueError("strengths of echoes that are none")
        self._rings, self._images, self._echoes = rings, state.images, float(rings[COUNT].sum())

    def count(self, echoes: Echoes, free: Mask, sector: Sector) -> None:
        """Take in the echoes of an image that no confirmed object explains, (m,) `free`, and that tell a strength."""
        self._rings *= MEMORY
        self._images = MEMORY * self._images + 1.0
        self._echoes = native.strength_count(self._rings, echoes.table, free, sector.range_min_m, sector.range_max_m)

    def typical(self, range_m: Floats, sector: Sector) -> Named[Typical]:
        """Return what echoes of nothing are like at (n,) ranges."""
        table = np.empty((len(Typical._fields), len(range_m)))
        ranges = sector.range_min_m, sector.range_max_m
        native.strength_typical(self._rings, range_m, ranges, POOLED, FEW, table)
        return Named(Typical, table)


def evidence(excess: float, echoes: float, sigma_db: float, known: float) -> float:
    """Return the log-likelihood ratio of a body over nothing that the mean strength of its echoes gives.

    excess: mean of (strength - mean) / sigma of so many `echoes`; `sigma_db`, `known`: as in `Typical`.
    """
    ratio: float = native.strength_evidence(excess, echoes, sigma_db, known, LAW)
    return ratio
