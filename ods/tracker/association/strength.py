"""How strong the echoes of nothing are: a body among the highlights of a bottom is told by what it has over them.

A rough bottom shows its highlights again and again, each in its place, so that they come back as a body does. But there
are many of them, of strengths that are alike, and a body is one of few. So the strengths of the echoes that no
confirmed object explains are counted, by range, and an object's mean strength is held against theirs: once, not for
each echo, as a highlight that is stronger than others stays so.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled.kernel import kernel
from ods.messages import Sector
from ods.tracker.measurement.scan import Echoes, echo_rows
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
LEAST_SIGMA_DB = 0.5
LASTING = 0.4
"""Part of the variance that is one of places, and does not average away over the images."""
SPAN_DB = 20.0
"""Bodies are of any strength within so wide a span."""
MOST = 7.0
"""Largest logarithm of a likelihood ratio that strength alone gives."""
COUNT, SUM, SQUARES = 0, 1, 2
LEAST = 1e-9
"""Keeps means over nothing finite."""


class Typical(NamedTuple):
    """The echoes of nothing, at n places: (n,) each."""

    mean_db: Floats
    sigma_db: Floats
    known: Floats
    """How much is known of them, from 0 to 1."""


@kernel
def typical_rows(table: Floats) -> Typical:
    """Name the rows of a (3, n) table."""
    return Typical(table[0], table[1], table[2])


class Strength:
    """Sums over the echoes of the last images that no confirmed object explains."""

    def __init__(self) -> None:
        self._rings = np.zeros((3, RANGES))
        self._images = 0.0

    @property
    def per_scan(self) -> float:
        """Echoes in an image, as far as it is known."""
        return float(self._rings[COUNT].sum()) / max(self._images, 1.0)

    def state(self) -> StrengthState:
        """Return what was counted."""
        return StrengthState(self._rings.ravel().tolist(), self._images)

    def restore(self, state: StrengthState) -> None:
        """Go on with what another one counted. Raises ValueError."""
        rings = np.array(state.rings, np.float64).reshape(self._rings.shape)
        counts = np.array([*rings[[COUNT, SQUARES]].ravel(), state.images])
        if not (np.isfinite(rings).all() and np.isfinite(counts).all() and (counts >= 0.0).all()):
            raise ValueError("strengths of echoes that are none")
        self._rings, self._images = rings, state.images

    def count(self, echoes: Echoes, free: Mask, sector: Sector) -> None:
        """Take in the echoes of an image that no confirmed object explains, (m,) `free`, and that tell a strength."""
        self._rings *= MEMORY
        self._images = MEMORY * self._images + 1.0
        _count(self._rings, echoes.table, free, sector.range_min_m, sector.range_max_m)

    def typical(self, range_m: Floats, sector: Sector) -> Named[Typical]:
        """Return what echoes of nothing are like at (n,) ranges."""
        return Named(Typical, _typical(self._rings, range_m, sector.range_min_m, sector.range_max_m))


@kernel
def _count(rings: Floats, table: Floats, free: Mask, nearest: float, farthest: float) -> None:
    echoes = echo_rows(table)
    for j in range(len(free)):
        strength = echoes.strength[j]
        if free[j] and strength > 0.0:
            ring = _ring(echoes.range_m[j], nearest, farthest)
            rings[COUNT, ring] += 1.0
            rings[SUM, ring] += strength
            rings[SQUARES, ring] += strength**2


@kernel
def _typical(rings: Floats, range_m: Floats, nearest: float, farthest: float) -> Floats:
    """Return the (3, n) table of `Typical`."""
    whole, table = rings.sum(axis=1), np.empty((3, len(range_m)))
    pooled, told = POOLED * whole / max(whole[COUNT], LEAST), typical_rows(table)
    for i in range(len(range_m)):
        ring = _ring(range_m[i], nearest, farthest)
        count = max(rings[COUNT, ring] + pooled[COUNT], LEAST)
        mean = (rings[SUM, ring] + pooled[SUM]) / count
        square = (rings[SQUARES, ring] + pooled[SQUARES]) / count
        told.mean_db[i], told.sigma_db[i] = mean, math.sqrt(max(square - mean**2, LEAST_SIGMA_DB**2))
        told.known[i] = rings[COUNT, ring] / (rings[COUNT, ring] + FEW)
    return table


@kernel
def _ring(range_m: float, nearest: float, farthest: float) -> int:
    return int(min(max((range_m - nearest) / (farthest - nearest) * RANGES, 0.0), RANGES - 1.0))


@kernel
def evidence(excess: float, echoes: float, sigma_db: float, known: float) -> float:
    """Return the log-likelihood ratio of a body over nothing that the mean strength of its echoes gives.

    excess: mean of (strength - mean) / sigma of so many `echoes`; `sigma_db`, `known`: as in `Typical`. Highlights
    follow the logistic law, whose tail falls as slowly as an exponential; what is no stronger than they are on average
    is taken to be at their mean.
    """
    if echoes == 0.0:
        return 0.0
    scale = math.sqrt(LASTING + (1.0 - LASTING) / max(echoes, 1.0)) * math.sqrt(3.0) / math.pi
    over = max(excess, 0.0) / scale
    of_highlight = -over - 2.0 * math.log1p(math.exp(-over)) - math.log(scale * sigma_db)
    return min(max(known * (-math.log(SPAN_DB) - of_highlight), -MOST), MOST)
