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
    """Hypotheses about n objects and the m echoes of an image, to be decided by the association."""

    hypotheses: Hypotheses
    first: Mask
    """(n,) objects that choose before the others."""
    echoes: Echoes
    predicted: Named[PredictedMeasurement]
    """(n,) arrays."""
    estimate: Estimate
    """Of n objects, as predicted."""


class Assignment(NamedTuple):
    """The k objects that were seen, and their echoes."""

    pairs: Hypotheses
    """(k,) the objects, each once, and the echo that is most likely its own."""
    echoes: Echoes
    """What each was seen by, (k,): that echo itself, or what stands for several."""
    explained: Mask
    """(m,) the echoes of the image that some object explains."""

    def plain(self) -> "Assignment":
        """Return it as kernels take it, whoever made it."""
        echoes = Echoes(np.ascontiguousarray(self.echoes.table))
        return Assignment(self.pairs.plain(), echoes, np.ascontiguousarray(self.explained, np.bool_))
