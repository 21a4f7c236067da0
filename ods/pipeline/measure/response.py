"""Width of a point in an image: speckle through a filter is correlated as far as the filter and the pulse reach."""

from ods.base.arrays import Image
from ods.compiled import native


def point_width(image: Image, background: float) -> float:
    """Return the width, columns, that a point has at half its level along the range.

    As loud cells are left out, narrow points come out narrower, by up to a fifth.
    """
    width: float = native.point_width(image, background)
    return width


def response_width(image: Image, background: float) -> float:
    """Return the width, columns, that the filter and the pulse give a point; 0 where no speckle shows it.

    Of what `point_width` counts, without what the bottom's own relief adds.
    """
    width: float = native.response_width(image, background)
    return width
