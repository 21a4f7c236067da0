"""Rise of an echo: short at an object's face, long at highlights of a rough bottom, which grow and fade."""

from ods.base.arrays import Image
from ods.compiled import native
from ods.pipeline.image.regions import Runs


def onset_of(image: Image, runs: Runs, point: float) -> float:
    """Return how far the echo's highest level lies behind the place before it that has half of that, in its beam.

    In units of `point`, the width of a point, columns (0: not known), whatever the levels of detection. Returns 0 where
    that is not known, or the image or its data begin later.
    """
    onset: float = native.onset_of(image, runs, point)
    return onset
