"""Pings and echoes made up for the tests of the pipeline."""

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Floats
from ods.messages import Detection, Ping
from ods.pipeline.measure.echoes import ECHO, EchoTable

DTYPE_NAMES = {"uint8": "u1", "uint16": "u2", "float32": "f4"}


def make_ping(frame: NDArray[Any], **changes: Any) -> Ping:
    """A ping of `frame` (beams, samples) over 90 deg, 5 cm a sample, linear; `changes` replace fields."""
    beams, samples = frame.shape
    fields: dict[str, Any] = {
        "seq": 3,
        "ping_number": 77,
        "t_ns": 10,
        "t_rx_ns": 20,
        "utc_ns": 30,
        "beams": beams,
        "samples": samples,
        "dtype": DTYPE_NAMES[frame.dtype.name],
        "data": frame.tobytes(),
        "bearing_rad": fan_bearings(beams).tolist(),
        "range0_m": 0.0,
        "dr_m": 0.05,
        "sound_speed": 1500.0,
    }
    return Ping(**(fields | changes))


def fan_bearings(beams: int, span_deg: float = 90.0) -> Floats:
    half = np.radians(span_deg) / 2.0
    return np.asarray(np.linspace(-half, half, beams + 1)[:-1] + half / beams)


def speckle(rng: np.random.Generator, mean_intensity: Floats) -> Floats:
    """Amplitude of fully developed speckle: exponentially distributed intensity."""
    return np.asarray(np.sqrt(mean_intensity * rng.exponential(size=mean_intensity.shape)))


def body_echo(shape: str, radius: float, range_m: float, bearing: float, beams: Floats, samples: int) -> Floats:
    """Mean intensity of a body, at most 1, (len(beams), samples) at 5 cm, received by Gaussian beams as wide as spaced.

    "disc": filled circle; "half": its near half; "wall": a line across, as long as the diameter.
    """
    rng = np.random.default_rng(1)
    count = 4000
    around, out = 2.0 * np.pi * rng.random(count), radius * np.sqrt(rng.random(count))
    across, away = out * np.sin(around), out * np.cos(around)
    if shape == "half":
        away = -np.abs(away)
    if shape == "wall":
        across, away = radius * (2.0 * rng.random(count) - 1.0), 0.1 * rng.random(count)
    x, y = range_m + away, across
    sigma = (beams[1] - beams[0]) / 2.3548
    column = np.rint(np.hypot(x, y) / 0.05).astype(np.int64)
    offset = beams[:, None] - (bearing + np.arctan2(y, x))
    image = np.zeros((len(beams), samples))
    for row, weight in zip(image, np.exp(-(offset**2) / (2.0 * sigma**2)), strict=True):
        np.add.at(row, column, weight)
    return np.asarray(image / image.max())


def echo_table(detections: Sequence[Detection]) -> EchoTable:
    """Detections as the chain has them before it hands them on."""
    return np.array([msgspec.structs.astuple(each)[: len(ECHO.fields or ())] for each in detections], ECHO)
