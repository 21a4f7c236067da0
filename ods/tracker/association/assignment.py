"""Input and result of an association."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Mask
from ods.tracker.association.hypotheses.gating import Hypotheses
from ods.tracker.measurement.model import PredictedMeasurement
from ods.tracker.measurement.scan import Echoes
from ods.tracker.named import Named
from ods.tracker.observer.belief import Estimate


class Question(NamedTuple):
    """Association problem: hypotheses about n objects and the m echoes of an image."""

    hypotheses: Hypotheses
    first: Mask
    """(n,) objects that are assigned before the others."""
    echoes: Echoes
    predicted: Named[PredictedMeasurement]
    """(n,) arrays."""
    estimate: Estimate
    """Of n objects, as predicted."""


class Assignment(NamedTuple):
    """The k objects that were seen, and their echoes."""

    pairs: Hypotheses
    """(k,) assigned objects, each once, with the most likely echo of each."""
    echoes: Echoes
    """(k,) the echo by which each object is corrected: its own, or the mean of several."""
    explained: Mask
    """(m,) echoes of the image that are explained by an object."""

    def plain(self) -> "Assignment":
        """Return it as kernels take it, whoever made it."""
        echoes = Echoes(np.ascontiguousarray(self.echoes.table))
        return Assignment(self.pairs.plain(), echoes, np.ascontiguousarray(self.explained, np.bool_))
