"""What an association is asked, and what it answers."""

from typing import NamedTuple

from ods.base.arrays import Mask
from ods.tracker.association.gating import Hypotheses
from ods.tracker.measurement.model import PredictedMeasurement
from ods.tracker.measurement.scan import Echoes
from ods.tracker.named import Named
from ods.tracker.observer.belief import Estimate


class Question(NamedTuple):
    """Which of the hypotheses about n objects and the m echoes of an image are true?"""

    hypotheses: Hypotheses
    first: Mask
    """(n,) objects that choose before the others."""
    echoes: Echoes
    predicted: Named[PredictedMeasurement]
    """(n,) arrays."""
    estimate: Estimate
    """Of n objects, as predicted."""


class Assignment(NamedTuple):
    """Which objects were seen, and by what: k of them."""

    pairs: Hypotheses
    """(k,) the objects, each once, and the echo that is most likely its own."""
    echoes: Echoes
    """What each was seen by, (k,): that echo itself, or what stands for several."""
    explained: Mask
    """(m,) the echoes of the image that some object explains."""
