"""Connected regions of an image, as runs of cells along the beams: what a detect stage hands on."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Image, Mask
from ods.compiled import native

RUN = np.dtype([("beam", np.int32), ("first", np.int32), ("stop", np.int32), ("region", np.int32)], align=True)
"""Neighbouring cells of one beam: columns `first` to `stop` - 1. Regions are numbered from 1."""
Runs = NDArray[np.void]
"""(runs,) of RUN; sorted by region, then beam, then column."""


class ThresholdedImage(NamedTuple):
    """Values that a detector compared with its levels."""

    image: Callable[[], Image]
    """Returns (beams, samples), the image that it got, or what it made of it; good until its next one."""
    low: float
    high: float


class Regions(NamedTuple):
    """The echoes of one image."""

    runs: Runs
    """Good until the detector's next image."""
    total: int
    """Number of regions; they are numbered 1..total without a gap."""
    background: float
    """Level of an image without echoes, above 0: what peak and mean levels are multiples of."""
    judged: ThresholdedImage | None = None
    """For pictures only; None: by no levels."""
    faint: Mask | None = None
    """(total,) those that are too weak for the false-alarm rate wanted; None: none is."""
    heard_from: float | None = None
    """So high over the background an echo counts by its level alone in the middle of the image; None: not reported."""
    fronts: bool = False
    """Where some are faint, all are judged by how they set in; of the faint ones only those are echoes that do so as a
    body does."""


def shared_at(regions: Regions, column: int) -> tuple[Regions, Regions]:
    """Return the regions that lie before a column that none reaches across, and the others."""
    beyond = np.zeros(regions.total, np.bool_)
    beyond[regions.runs["region"] - 1] = regions.runs["first"] >= column
    return select_regions(regions, ~beyond), select_regions(regions, beyond)


def select_regions(regions: Regions, wanted: Mask) -> Regions:
    """Return the wanted regions, (total,), renumbered without a gap."""
    out = np.empty_like(regions.runs)
    runs = out[: native.choose_runs(regions.runs, wanted, out)]
    faint = None if regions.faint is None else regions.faint[wanted]
    return Regions(runs, int(np.count_nonzero(wanted)), regions.background, faint=faint)


def sorted_runs(runs: Runs) -> Runs:
    """Return the runs of numbered regions, by region, beam and column."""
    out = np.empty_like(runs)
    return out[: native.sort_runs(runs, out)]
