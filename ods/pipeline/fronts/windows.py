"""The recorded samples around where an echo sets in, as levels: what is judged of it."""

from collections.abc import Sequence

import numpy as np

from ods.base.arrays import AnyArray, Floats, Floats32, Ints
from ods.messages import Detection
from ods.pipeline.image.amplitude import Decimation, SampleScale, to_amplitude
from ods.pipeline.image.fan import Fan
from ods.pipeline.image_layout import ImageLayout

CELL_M, LONGEST_CELL = 0.1, 1.34
"""Length of a cell along the range; the samples of a cell make 0.67 to so many times that."""
BEAMS, CELLS = 9, 48
"""Size of a window,"""
BEFORE = 20
"""of whose cells so many lie before the place where the echo is said to set in."""
LEAST = np.float32(0.01)
"""Of a window's mean amplitude, added to each, so that none is not infinitely below its surroundings."""
TINY = np.float32(1e-30)
BEAM_STEP_RAD = np.radians((1.0, 2.0))
"""Beams this far apart are like those that bodies were learnt from."""


def can_be_judged(fan: Fan) -> bool:
    """Tell whether beams and columns of an image are such as bodies were learnt from."""
    step = np.diff(fan.bearing_rad)
    beams = step.size >= BEAMS and np.all((step > BEAM_STEP_RAD[0]) & (step < BEAM_STEP_RAD[1]))
    return bool(beams) and fan.dr_m <= LONGEST_CELL * CELL_M


class Windows:
    """Cuts windows out of the samples of a plane of beams."""

    def __init__(self, layout: ImageLayout) -> None:
        """Find the samples of a cell. layout: what of the frame the echoes were found in."""
        band = layout.bands[0]
        dr_m = band.fan.dr_m / layout.stride
        self.stride = max(1, round(CELL_M / dr_m))
        """Samples of a cell."""
        self._dr_m = dr_m
        self._begin_m = band.fan.range0_m - (0.5 * layout.stride + band.first) * dr_m
        self._bearing_rad = band.fan.bearing_rad

    def of(self, echoes: Sequence[Detection], samples: AnyArray, scale: SampleScale) -> Floats32:
        """Return the levels around echoes, dB over their mean: (echoes, BEAMS, CELLS) float32.

        samples: (beams, samples) of the plane. What lies beyond them is as the nearest that they have.
        """
        beam = self._nearest_beam(np.array([echo.bearing_rad for echo in echoes]))
        first = np.array([(echo.near_m - self._begin_m) / self._dr_m for echo in echoes], np.int64)
        rows = _around(beam, BEAMS // 2, BEAMS, len(samples))
        columns = _around(first, BEFORE * self.stride, CELLS * self.stride, samples.shape[1])
        found = samples[rows[:, :, None], columns[:, None, :]].reshape(-1, CELLS * self.stride)
        return _levels(self._amplitude(found, scale).reshape(-1, BEAMS, CELLS))

    def _amplitude(self, found: AnyArray, scale: SampleScale) -> Floats32:
        """Return the mean amplitude of each cell, (rows, CELLS), of samples (rows, samples of these cells)."""
        if scale.table is not None:  # by numpy: the kernel of `to_amplitude` is compiled for recorded samples
            return np.asarray(scale.table[found].reshape(-1, CELLS, self.stride).mean(axis=2, dtype=np.float32))
        amplitude = np.empty((len(found), CELLS), np.float32)
        to_amplitude(found, Decimation(0, self.stride, 0, CELLS), scale, amplitude)
        return amplitude

    def _nearest_beam(self, bearing_rad: Floats) -> Ints:
        return np.asarray(np.abs(self._bearing_rad - bearing_rad[:, None]).argmin(axis=1))


def _levels(amplitude: Floats32) -> Floats32:
    """Return the levels of windows, dB over the mean level of each; 0 where there is nothing at all."""
    mean = amplitude.mean(axis=(1, 2), keepdims=True)
    level = 20.0 * np.log10(amplitude / np.maximum(mean, TINY) + LEAST, dtype=np.float32)
    return np.asarray(level - level.mean(axis=(1, 2), keepdims=True))


def _around(place: Ints, before: int, count: int, size: int) -> Ints:
    """Return (places, count) the indices around each place."""
    return np.asarray(np.clip(place[:, None] + np.arange(-before, count - before), 0, size - 1))
