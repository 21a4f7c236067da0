"""Faults of a sonar that still pings: what its image shows then."""

from collections.abc import Callable, Mapping

from ods.base.arrays import Image

BLOCKED = 0.1
"""What a blocked head leaves of all amplitudes: 20 dB less."""
FULL_SCALE = 1e9
"""More than any count."""


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


BLINDNESS: Mapping[str, Callable[[Image], None]] = {
    "zeros": _zeros,
    "dead_beams": _dead_beams,
    "cut_beams": _cut_beams,
    "head_blocked": _head_blocked,
    "saturated": _saturated,
}
"""By `FaultSettings.kind`: changes an image, (beams, samples) amplitude in counts, in place."""
