"""What the chain measures of echoes, beside their detections: what the laws of circles' sigmas are fitted to."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple
from unittest.mock import patch

from benchmarks.circles.synthetic import Look
from ods.base.arrays import Image
from ods.messages import Detection
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.regions import Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pipeline.measure import pieces
from ods.pipeline.measure.echoes import EchoTable, measure
from ods.pipeline.measure.sigmas.features import Features


class Seen(NamedTuple):
    """A body of which an echo was found."""

    look: Look
    point_m: float
    """Width of a point along the line of sight."""
    features: Features


class Received:
    """The features of the echoes of the last images."""

    def __init__(self) -> None:
        self._features: dict[tuple[float, float], tuple[float, Features]] = {}

    def forget(self) -> None:
        """Forget those of the images before."""
        self._features.clear()

    def seen(self, look: Look, found: Detection) -> Seen:
        """Return what was found of a body, with the features of its echo."""
        return Seen(look, *self._features[found.near_m, found.bearing_rad])

    def listen(self, image: Image, regions: Regions, recorded: Recorded, fan: Fan) -> EchoTable:
        """Measure as the chain does, and keep the features."""
        reported = measure(image, regions, recorded, fan)
        point_m = reported.point * fan.dr_m
        for echo, features in zip(reported.echoes, reported.features.tolist(), strict=True):
            self._features[float(echo["near_m"]), float(echo["bearing_rad"])] = point_m, Features(*features)
        return reported.echoes


@contextmanager
def received() -> Iterator[Received]:
    """Keep the features of what all chains of this process measure."""
    reported = Received()
    with patch.object(pieces, "measure_echoes", reported.listen):
        yield reported
