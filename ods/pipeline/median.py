"""Median filter along the beam by sorting networks; the image is mirrored at the range ends."""

import numpy as np

from ods.pipeline.fan import Fan, Image
from ods.pipeline.kernel import kernel
from ods.pipeline.mirror import Row, mirror_row
from ods.pipeline.params import MedianParams
from ods.pipeline.registry import ImageStep, image_stage


@image_stage("filter.median", MedianParams)
def median(params: MedianParams, fan: Fan) -> ImageStep:
    """Median of a window of range samples: takes out speckle and keeps edges where they are."""
    window = params.window
    padded = np.empty(fan.samples + window, np.float32)
    ordered = np.empty((3, fan.samples + window), np.float32)

    def step(source: Image, out: Image) -> None:
        median_filter(source, window, padded, ordered, out)

    return step


@kernel
def median_filter(image: Image, window: int, padded: Row, ordered: Image, out: Image) -> None:
    """Fill out with the median of image (beams, samples) over 3, 5, 7 or 9 range samples.

    padded (samples + window - 1) and ordered (3, samples + window - 1) are work space.
    """
    for b in range(image.shape[0]):
        mirror_row(image[b], window // 2, padded)
        if window == 3:
            _median_of_3(padded, out[b])
        elif window == 5:
            _median_of_5(padded, out[b])
        elif window == 7:
            _median_of_7(padded, ordered, out[b])
        else:
            _median_of_9(padded, ordered, out[b])


@kernel
def _low(a: np.float32, b: np.float32) -> np.float32:
    return a if a < b else b


@kernel
def _high(a: np.float32, b: np.float32) -> np.float32:
    return b if a < b else a


@kernel
def _middle(a: np.float32, b: np.float32, c: np.float32) -> np.float32:
    return _high(_low(a, b), _low(_high(a, b), c))


@kernel
def _median_of_3(padded: Row, out: Row) -> None:
    samples = out.size
    a, b, c = padded[:samples], padded[1 : 1 + samples], padded[2 : 2 + samples]
    for j in range(samples):
        out[j] = _middle(a[j], b[j], c[j])


@kernel
def _median_of_5(padded: Row, out: Row) -> None:
    """Of two pairs, the lower of the lower ends and the higher of the higher ends cannot be the median."""
    samples = out.size
    a, b, c = padded[:samples], padded[1 : 1 + samples], padded[2 : 2 + samples]
    d, e = padded[3 : 3 + samples], padded[4 : 4 + samples]
    for j in range(samples):
        low = _high(_low(a[j], b[j]), _low(c[j], d[j]))
        high = _low(_high(a[j], b[j]), _high(c[j], d[j]))
        out[j] = _middle(low, high, e[j])


@kernel
def _sort_triples(padded: Row, ordered: Image, count: int) -> None:
    """Sort padded[j : j + 3] into ordered[:, j] for j < count: neighbouring windows share these triples."""
    a, b, c = padded[:count], padded[1 : 1 + count], padded[2 : 2 + count]
    low, middle, high = ordered[0], ordered[1], ordered[2]
    for j in range(count):
        small, large = _low(a[j], b[j]), _high(a[j], b[j])
        rest = _high(small, c[j])
        low[j] = _low(small, c[j])
        middle[j] = _low(large, rest)
        high[j] = _high(large, rest)


@kernel
def _median_of_7(padded: Row, ordered: Image, out: Row) -> None:
    """Of two sorted triples, the third and the fourth value bracket the median of the triples and one more."""
    samples = out.size
    _sort_triples(padded, ordered, samples + 3)
    last = padded[6 : 6 + samples]
    a1, a2, a3 = ordered[0, :samples], ordered[1, :samples], ordered[2, :samples]
    b1, b2, b3 = ordered[0, 3 : 3 + samples], ordered[1, 3 : 3 + samples], ordered[2, 3 : 3 + samples]
    for j in range(samples):
        third = _low(_low(a3[j], b3[j]), _low(_high(a1[j], b2[j]), _high(a2[j], b1[j])))
        fourth = _high(_high(a1[j], b1[j]), _high(_low(a3[j], b2[j]), _low(a2[j], b3[j])))
        out[j] = _middle(third, fourth, last[j])


@kernel
def _median_of_9(padded: Row, ordered: Image, out: Row) -> None:
    """Of three sorted triples: the middle of the highest low, the middle middle and the lowest high value."""
    samples = out.size
    _sort_triples(padded, ordered, samples + 6)
    low, low2, low3 = ordered[0, :samples], ordered[0, 3 : 3 + samples], ordered[0, 6 : 6 + samples]
    for j in range(samples):
        out[j] = _high(_high(low[j], low2[j]), low3[j])
    middle, middle2, middle3 = ordered[1, :samples], ordered[1, 3 : 3 + samples], ordered[1, 6 : 6 + samples]
    high, high2, high3 = ordered[2, :samples], ordered[2, 3 : 3 + samples], ordered[2, 6 : 6 + samples]
    for j in range(samples):
        highest = _low(_low(high[j], high2[j]), high3[j])
        out[j] = _middle(out[j], _middle(middle[j], middle2[j], middle3[j]), highest)
