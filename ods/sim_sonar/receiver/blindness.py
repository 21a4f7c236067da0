"""Faults of a sonar that still pings, and noise of others: what its image shows then."""

import zlib
from collections.abc import Callable, Mapping

import numpy as np

from ods.base.arrays import Image

BLOCKED = 0.1
"""What a blocked head leaves of all amplitudes: 20 dB less."""
FULL_SCALE = 1e9
"""More than any count."""
LOUD = 10.0
"""A loud spell's noise over the median amplitude: 20 dB."""


def _zeros(image: Image) -> None:
    image[:] = 0.0


def _dead_beams(image: Image) -> None:
    image[: len(image) // 2] = 0.0


def _cut_beams(image: Image) -> None:
    image[:, image.shape[1] // 2 :] = 0.0


def _head_blocked(image: Image) -> None:
    image *= BLOCKED


def _saturated(image: Image) -> None:
    image[:] = FULL_SCALE


def _loud(image: Image) -> None:
    """Add Rayleigh distributed noise; another one in each ping, and the same each time that the ping is made."""
    rng = np.random.default_rng(zlib.crc32(image.tobytes()))
    image += rng.rayleigh(LOUD * float(np.median(image)), image.shape).astype(image.dtype)


BLINDNESS: Mapping[str, Callable[[Image], None]] = {
    "zeros": _zeros,
    "dead_beams": _dead_beams,
    "cut_beams": _cut_beams,
    "head_blocked": _head_blocked,
    "saturated": _saturated,
    "loud": _loud,
}
"""By `FaultSettings.kind`, `loud` too: changes an image, (beams, samples) amplitude in counts, in place."""
