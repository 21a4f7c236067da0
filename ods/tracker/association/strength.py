"""How strong the echoes of nothing are: a body among the highlights of a bottom is told by what it has over them.

A rough bottom shows its highlights again and again, each in its place, so that they come back as a body does. But there
are many of them, of strengths that are alike, and a body is one of few. So the strengths of the echoes that no
confirmed object explains are counted, by range, and an object's mean strength is held against theirs: once, not for
each echo, as a highlight that is stronger than others stays so.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.messages import Sector
from ods.tracker.measurement.scan import Echoes
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

    def count(self, echoes: Echoes, sector: Sector) -> None:
        """Take in the echoes of an image that no confirmed object explains; those without a strength do not count."""
        self._rings *= MEMORY
        self._images = MEMORY * self._images + 1.0
        strength = echoes.rows.strength
        told = strength > 0.0
        ring, strength = _ring(echoes.rows.range_m[told], sector), strength[told]
        for row, values in enumerate((np.ones(len(strength)), strength, strength**2)):
            self._rings[row] += np.bincount(ring, values, RANGES)

    def typical(self, range_m: Floats, sector: Sector) -> Typical:
        """Return what echoes of nothing are like at (n,) ranges."""
        counted = self._rings[COUNT]
        whole = self._rings.sum(axis=1, keepdims=True)
        sums = self._rings + POOLED * whole / max(float(whole[COUNT, 0]), LEAST)
        count = np.maximum(sums[COUNT], LEAST)
        mean = sums[SUM] / count
        sigma = np.sqrt(np.maximum(sums[SQUARES] / count - mean**2, LEAST_SIGMA_DB**2))
        ring = _ring(range_m, sector)
        return Typical(mean[ring], sigma[ring], (counted / (counted + FEW))[ring])


def _ring(range_m: Floats, sector: Sector) -> np.typing.NDArray[np.intp]:
    share = (range_m - sector.range_min_m) / (sector.range_max_m - sector.range_min_m)
    return np.clip(share * RANGES, 0.0, RANGES - 1.0).astype(np.intp)


def evidence(excess: Floats, echoes: Floats, typical: Typical) -> Floats:
    """Return (n,) the log-likelihood ratio of a body over nothing that the mean strength of its echoes gives.

    excess: (n,) mean of (strength - mean) / sigma of so many `echoes`. Highlights follow the logistic law, whose tail
    falls as slowly as an exponential; what is no stronger than they are on average is taken to be at their mean.
    """
    spread = np.sqrt(LASTING + (1.0 - LASTING) / np.maximum(echoes, 1.0))
    scale = spread * math.sqrt(3.0) / math.pi
    over = np.maximum(excess, 0.0) / scale
    of_highlight = -over - 2.0 * np.log1p(np.exp(-over)) - np.log(scale * typical.sigma_db)
    ratio = np.where(echoes > 0.0, typical.known * (-math.log(SPAN_DB) - of_highlight), 0.0)
    return np.asarray(np.clip(ratio, -MOST, MOST))
