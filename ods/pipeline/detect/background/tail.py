"""Tail of the background: the level that a given share of the cells without echoes exceeds."""

from collections.abc import Iterable

import numpy as np

from ods.base.arrays import Floats, Image
from ods.compiled import native
from ods.pipeline.detect.background.noise import background_and_noise

_BINS = 16384
_SPAN = 32.0
"""The histogram reaches to this multiple of the background; all that is higher goes into its last bin."""
_BULK = np.array([0.2, 0.02, 0.002])
"""Shares of the cells at which the shape of the distribution is measured."""
_TAIL = np.logspace(-2.0, -5.0, 7)
"""Shares of the cells of speckle that its tail is fitted at, two a decade,"""
_WEIGHT = 0.4
"""each weighted by this power of the share."""
_PARTS = 4
"""Parts of an image's beams; each image contributes one, in turn, but the first _RENEWED ones, which are whole."""
_REMEMBERED = 1_500_000
"""Least number of cells that are remembered, the most being twice as many."""
_RENEWED = 16
"""The level is computed again when one part in this many of the remembered cells is new. Also the number of pings over
which the spread, which distinguishes echoes from noise, is averaged."""


class TailQuantile:
    """Derives levels from the bulk of the last images of one chain, by how the tail follows from the bulk.

    The logarithm of the level, in units of the background, is a linear function of the logarithms of three quantiles.
    What they stand for is no law of amplitudes: it is learnt from images of known kinds behind the same stages.
    """

    def __init__(self, rate: float) -> None:
        """rate: the share of the cells without echoes that shall be above the level."""
        self._rate = rate
        self._counted = np.zeros((2, _BINS))
        """Of cells where no echo is, and of those that may be an echo's."""
        self._former = np.zeros(_BINS)
        self._quiet, self._quiet_before, self._renewed_at = 0, 0, 0
        """Cells that `_counted` and `_former` have where no echo is; of both, when the level was last worked out."""
        self._spread, self._images = 0.0, 0
        self._over = 0.5 * np.log(np.log(rate) / np.log(0.5))
        """Logarithm of level / background: of Rayleigh distributed amplitudes, until more is known."""
        self._level_of = np.array([self._over, *np.zeros(len(_BULK))])

    def learn(self, kinds: Iterable[Iterable[Image]]) -> None:
        """Take in how the tail follows from the bulk; of images without echoes, kind by kind."""
        bulks, levels, steepness = [], [], []
        for images in kinds:
            counted = np.zeros((2, _BINS))
            for image in images:
                background, noise = background_and_noise(image)
                if background > 0.0:
                    crest = background * crest_over(float(np.log1p(noise / background)))
                    _count(image, (0, len(image)), crest, background, counted)
            if counted[0].any():
                at = _log_quantiles(counted.sum(axis=0), _TAIL)
                tail = np.polyfit(_log_log(_TAIL), at, 2, w=_TAIL**_WEIGHT)
                bulks.append([1.0, *_log_quantiles(counted[0], _BULK)])
                levels.append(np.polyval(tail, _log_log(np.array(self._rate))))
                steepness.append(1.0 / max(at[4] - at[0], 1e-6))  # from a share of 1e-2 to 1e-4
        if bulks:  # of a level's error counts by what factor the rate is then wrong
            weight = np.array(steepness)
            weighted = np.array(bulks) * weight[:, None], np.array(levels) * weight
            self._level_of = np.linalg.lstsq(*weighted, rcond=None)[0]

    def level(self, image: Image, background: float, noise: float) -> float:
        """Return the level of an image (beams, samples) of such a background and noise (`background_and_noise`)."""
        self._images += 1
        self._spread += (float(np.log1p(noise / background)) - self._spread) / min(self._images, _RENEWED)
        beams, part = len(image), self._images % _PARTS
        rows = (part * beams // _PARTS, (part + 1) * beams // _PARTS) if self._images > _RENEWED else (0, beams)
        crest = background * crest_over(self._spread)
        self._quiet += _count(image, rows, crest, background, self._counted)
        self._renew()
        return background * float(np.exp(self._over))

    def _renew(self) -> None:
        count = self._quiet_before + self._quiet
        if count - self._renewed_at <= count / _RENEWED:
            return
        bulk = _log_quantiles(self._former + self._counted[0], _BULK)
        self._over = max(self._level_of @ (1.0, *bulk), bulk[-1])
        self._renewed_at = count
        if self._quiet > _REMEMBERED:
            self._former[:] = self._counted[0]
            self._counted[:] = 0
            self._renewed_at = self._quiet_before = self._quiet
            self._quiet = 0


def crest_over(spread: float) -> float:
    """Return how many times the background a cell is at least that, with all around it, is taken for an echo's.

    spread: log(1 + noise / background). Of speckle, whatever its kind and the filter, one cell in 100,000 or less is as
    high; what that takes from the bulk of noise is learnt with it.
    """
    return float(np.exp(4.2 * spread / (1.0 + 0.15 * spread)))


def _count(image: Image, rows: tuple[int, int], crest: float, background: float, counted: Floats) -> int:
    """Add the cells of some beams of image to the (2, bins) histograms; return how many are where no echo is.

    Those in blocks that are, or touch, one with a cell above `crest` may be an echo's.
    """
    count: int = native.count_cells(image, rows, crest, _BINS / (_SPAN * background), counted)
    return count


def _log_log(shares: Floats) -> Floats:
    return np.asarray(np.log(-np.log(shares)))


def _log_quantiles(histogram: Floats, shares: Floats) -> Floats:
    """Return the logarithms of the levels, in units of the background, that shares of the cells exceed."""
    up_to = np.cumsum(histogram)
    bins = np.interp((1.0 - shares) * up_to[-1], up_to, np.arange(1.0, _BINS + 1.0))
    return np.asarray(np.log(np.maximum(bins, 1.0) * _SPAN / _BINS))
