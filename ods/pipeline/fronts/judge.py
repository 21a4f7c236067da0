"""Does an echo set in as an object's does? The network judges the recorded samples around that place, as levels."""

from functools import cached_property

import numpy as np

from ods.base.arrays import AnyArray, Floats, Floats32, Ints
from ods.compiled import native
from ods.pipeline.fronts.network import learnt
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.image_layout import ImageLayout
from ods.pipeline.image.samples.amplitude import Decimation, SampleScale, to_amplitude

CELL_M, LONGEST_CELL = 0.1, 1.34
"""Length of a cell along the range; the samples of a cell make 0.67 times that to this ratio."""
BEAMS, CELLS = 9, 48
"""Size of a window,"""
BEFORE = 20
"""Number of its cells before the estimated start of the echo."""
APART_RAD = np.radians((2.0 / 3.0, 2.0))
"""From one beam of a window to the next, which is the width of a beam: in between, beams of the fan are left out."""
LEAST_FRONT = 0.12
"""Of `Detection.front`, for weak detections. The tracker sees many images: one that is taken for the bottom now and
then costs less than a body that is never received."""
MIN_REPORTED = 1e-6
"""Least probability that is reported for a leading edge: 0 stands for an unknown one."""


def can_be_judged(fan: Fan) -> bool:
    """Return whether beams and columns of an image make windows like those that bodies were learnt from."""
    gap = np.diff(fan.bearing_rad)
    if gap.size < BEAMS or gap.min() <= 0.0 or fan.dr_m > LONGEST_CELL * CELL_M:
        return False
    strides = _beam_strides(fan)
    apart = strides * np.gradient(fan.bearing_rad)
    least, most = APART_RAD
    return bool(gap.size >= BEAMS * strides.max() and apart.min() > least and apart.max() < most)


def _beam_strides(fan: Fan) -> Ints:
    """Return how many beams on from each the next one of a window is, (beams,): about the width of a beam."""
    return np.maximum(np.rint(fan.beam_width_rad / np.gradient(fan.bearing_rad)), 1.0).astype(np.int64)


class LeadingEdgeJudge:
    """Judges the echoes of one image of a frame, by windows cut out of the samples of a plane of beams."""

    def __init__(self, layout: ImageLayout) -> None:
        """Find the samples of a cell. layout: what of the frame the echoes were found in."""
        band = layout.bands[0]
        dr_m = band.fan.dr_m / layout.stride
        self.stride = max(1, round(CELL_M / dr_m))
        """Samples of a cell."""
        self._dr_m = dr_m
        self._begin_m = band.fan.range0_m - (0.5 * layout.stride + band.first) * dr_m
        self._fan = band.fan

    @cached_property
    def _beam_strides(self) -> Ints:
        return _beam_strides(self._fan)

    def windows(self, bearing_rad: Floats, near_m: Floats, samples: AnyArray, scale: SampleScale) -> Floats32:
        """Return the levels around echoes, dB over their mean: (echoes, BEAMS, CELLS) float32.

        bearing_rad, near_m: (echoes,) where they set in.
        samples: (beams, samples) of the plane. What lies beyond them is as the nearest that they have.
        """
        places = np.column_stack((bearing_rad, (near_m - self._begin_m) / self._dr_m))
        found = np.empty((len(places), BEAMS, CELLS * self.stride), samples.dtype)
        native.cut_windows(samples, self._fan.bearing_rad, self._beam_strides, places, BEFORE * self.stride, found)
        windows = np.empty((len(places), BEAMS, CELLS), np.float32)
        cells = Decimation(0, self.stride, 0, CELLS)
        to_amplitude(found.reshape(-1, CELLS * self.stride), cells, scale, windows.reshape(-1, CELLS))
        native.level_windows(windows)
        return windows

    def of(self, bearing_rad: Floats, near_m: Floats, samples: AnyArray, scale: SampleScale) -> Floats:
        """Return the `front` of echoes, (echoes,): see `windows`."""
        scores = learnt().scores(self.windows(bearing_rad, near_m, samples, scale)).astype(np.float64)
        return np.maximum(1.0 / (1.0 + np.exp(-scores)), MIN_REPORTED)
