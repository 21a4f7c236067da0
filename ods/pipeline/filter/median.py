"""Median filter along the beam by sorting networks, and across; the image is mirrored at the range ends."""

import numpy as np

from ods.base.arrays import Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, load_mirrored
from ods.pipeline.image.padding import mirrored
from ods.pipeline.stage.params import MedianParams
from ods.pipeline.stage.registry import gained_image_stage
from ods.pipeline.stage.step import GainedImageStep


@gained_image_stage("filter.median", MedianParams)
def median(params: MedianParams, fan: Fan) -> GainedImageStep:
    """Median of a window of range samples: takes out speckle and keeps edges where they are.

    Across the beams, the median of the beams' medians: almost the median of the whole window, at a tenth of its cost.
    """
    window = params.window
    padded = np.empty(fan.samples + window, np.float32)
    ordered = np.empty((3, fan.samples + window), np.float32)
    ring = np.empty((params.beams, fan.samples), np.float32)

    def step(image: GainedImage, out: Image) -> None:
        median_filter(image, window, padded, ordered, ring, out)

    return step


@kernel
def median_filter(image: GainedImage, window: int, padded: Floats32, ordered: Image, ring: Image, out: Image) -> None:
    """Fill out with the median of the image over 3, 5, 7 or 9 range samples and 1, 3 or 5 beams.

    padded (samples + window - 1,), ordered (3, samples + window - 1) and ring (beams of the window, samples) are work
    space.
    """
    beams = out.shape[0]
    reach = ring.shape[0] // 2
    for b in range(-reach, beams + reach):
        load_mirrored(image, mirrored(b, beams), window // 2, padded)
        _median_row(padded, window, ordered, out[b] if reach == 0 else ring[(b + reach) % ring.shape[0]])
        if b < reach or reach == 0:
            continue
        if reach == 1:
            _median_of_3_rows(ring[0], ring[1], ring[2], out[b - reach])
        else:
            _median_of_5_rows(ring[0], ring[1], ring[2], ring[3], ring[4], out[b - reach])


@kernel
def _median_row(padded: Floats32, window: int, ordered: Image, out: Floats32) -> None:
    n = out.size
    if window == 3:
        _median_of_3_rows(padded[:n], padded[1 : 1 + n], padded[2 : 2 + n], out)
    elif window == 5:
        a, b, c, d, e = padded[:n], padded[1 : 1 + n], padded[2 : 2 + n], padded[3 : 3 + n], padded[4 : 4 + n]
        _median_of_5_rows(a, b, c, d, e, out)
    elif window == 7:
        _median_of_7(padded, ordered, out)
    else:
        _median_of_9(padded, ordered, out)


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
def _median_of_3_rows(a: Floats32, b: Floats32, c: Floats32, out: Floats32) -> None:
    for j in range(out.size):
        out[j] = _middle(a[j], b[j], c[j])


@kernel
def _median_of_5_rows(a: Floats32, b: Floats32, c: Floats32, d: Floats32, e: Floats32, out: Floats32) -> None:
    """Of two pairs, the lower of the lower ends and the higher of the higher ends cannot be the median."""
    for j in range(out.size):
        low = _high(_low(a[j], b[j]), _low(c[j], d[j]))
        high = _low(_high(a[j], b[j]), _high(c[j], d[j]))
        out[j] = _middle(low, high, e[j])


@kernel
def _sort_triples(padded: Floats32, ordered: Image, count: int) -> None:
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
def _median_of_7(padded: Floats32, ordered: Image, out: Floats32) -> None:
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
def _median_of_9(padded: Floats32, ordered: Image, out: Floats32) -> None:
    """Of three sorted triples: the middle of the highest low, the middle middle and the lowest high value."""
    samples = out.size
    _sort_triples(padded, ordered, samples + 6)
    low, low2, low3 = ordered[0, :samples], ordered[0, 3 : 3 + samples], ordered[0, 6 : 6 + samples]
    middle, middle2, middle3 = ordered[1, :samples], ordered[1, 3 : 3 + samples], ordered[1, 6 : 6 + samples]
    high, high2, high3 = ordered[2, :samples], ordered[2, 3 : 3 + samples], ordered[2, 6 : 6 + samples]
    for j in range(samples):
        lowest = _high(_high(low[j], low2[j]), low3[j])
        highest = _low(_low(high[j], high2[j]), high3[j])
        out[j] = _middle(lowest, _middle(middle[j], middle2[j], middle3[j]), highest)
