"""Recorded samples as the first stage gets them."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Mask
from ods.compiled import native
from ods.pipeline.image.gained_image import DoubleBuffer, GainedImage, of_gain_1
from ods.pipeline.image.image_layout import ImageLayout
from ods.pipeline.image.missing.fill import draw
from ods.pipeline.image.missing.no_data import ALL_DATA
from ods.pipeline.image.missing.threshold import AMPLITUDES, ThresholdFiller
from ods.pipeline.image.samples.amplitude import Decimation, SampleScale, mean_offset, to_amplitude
from ods.pipeline.image.samples.recorded import Frame, Recorded
from ods.pipeline.stage.params import MeanRangeParams

_RANGE = MeanRangeParams()
_QUIET = 0.25
"""From this share of zero counts on, a count is no small part of the noise."""


class ReadImage(NamedTuple):
    """An image of a frame."""

    image: GainedImage
    """It may share the memory of the frame."""
    recorded: Recorded
    """What it was made of."""
    gaps: Mask
    """(beams, columns) cells whose samples all have no data; `ALL_DATA` if there are none."""


class FrameReader:
    """Makes an image of rows of a frame: linear counts are left as they are, all others become amplitudes.

    Where there are samples without data, or most are of few counts, the image is written: gaps are filled, and counts
    are dithered. Else a step of one count would be taken for an echo where all around is the same count.
    """

    def __init__(self, layout: ImageLayout, buffers: DoubleBuffer) -> None:
        self._layout = layout
        self._buffers = buffers
        self._of_gain_1 = of_gain_1(buffers.back)._replace(offset=mean_offset(layout.stride))
        self._columns = [
            Decimation(int(layout.origin[band.columns.start]), layout.stride, band.columns.start, band.columns.stop)
            for band in layout.bands
        ]
        self._averaged: dict[np.dtype[np.generic], AnyArray] = {}
        self._drawn = draw()
        self._threshold = ThresholdFiller()

    def read(self, frame: Frame) -> ReadImage:
        """Return the image of the layout's rows and ranges of a frame."""
        layout, buffers, scale = self._layout, self._buffers, frame.scale
        missing = frame.missing[layout.rows] if frame.missing.size else frame.missing
        recorded = Recorded(frame.samples[layout.rows], layout.origin, layout.stride, missing)
        gaps = ALL_DATA
        if missing.size:
            recorded, gaps = _with_samples_lent(recorded), _cells_without_data(recorded)
        rows = recorded.samples
        if self._threshold.is_needed(recorded, scale):
            rows, scale = self._threshold.filled(recorded, scale, frame.number), AMPLITUDES
        are_counts = scale.scale == "linear" and rows.dtype.kind == "u"
        image = self._counts(rows) if are_counts else self._amplitudes(rows, scale)
        if are_counts and native.share_of_zeros(rows, self._columns[0].first) > _QUIET:
            image = buffers.apply(image)
            native.dither(buffers.front, self._drawn.dither, frame.number)
        if gaps.size:
            image = buffers.apply(image)
            native.fill_gaps(buffers.front, gaps, self._drawn.speckle, frame.number, _RANGE.guard, _RANGE.window)
        return ReadImage(image, recorded, gaps)

    def _amplitudes(self, rows: AnyArray, scale: SampleScale) -> GainedImage:
        for columns in self._columns:
            to_amplitude(rows, columns, scale, self._buffers.back)
        return self._buffers.flip()

    def _counts(self, rows: AnyArray) -> GainedImage:
        """Return counts as they are, or their means, rounded down."""
        if self._layout.stride == len(self._columns) == 1:
            return self._of_gain_1._replace(cells=rows, first=self._columns[0].first)
        if rows.dtype not in self._averaged:
            self._averaged[rows.dtype] = np.empty(self._buffers.back.shape, rows.dtype)
        counts = self._averaged[rows.dtype]
        for columns in self._columns:
            native.average_counts(rows, columns, counts)
        return self._of_gain_1._replace(cells=counts)


def _with_samples_lent(recorded: Recorded) -> Recorded:
    """Return the same with no sample without data in a cell that has some, as a cell is its samples' mean.

    Such samples get the mean of those around that hold data.
    """
    if recorded.stride == 1:
        return recorded
    samples = recorded.samples.copy()
    native.lend_samples(recorded, samples)
    return recorded._replace(samples=samples)


def _cells_without_data(recorded: Recorded) -> Mask:
    cells = np.empty((len(recorded.samples), len(recorded.origin)), np.bool_)
    return cells if native.cells_without_data(recorded, cells) else ALL_DATA
