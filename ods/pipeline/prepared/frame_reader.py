"""Recorded samples as the first stage gets them."""

import numpy as np

from ods.base.arrays import AnyArray, Mask
from ods.pipeline.image.double_buffer import DoubleBuffer
from ods.pipeline.image.gained_image import GainedImage, of_gain_1
from ods.pipeline.image.image_layout import ImageLayout
from ods.pipeline.image.missing.fill import dither, draw, fill_gaps
from ods.pipeline.image.missing.no_data import share_of_zeros
from ods.pipeline.image.samples.amplitude import Decimation, SampleScale, average_counts, mean_offset, to_amplitude

_QUIET = 0.25
"""From this share of zero counts on, a count is no small part of the noise."""
_LOOKED_AT = 512
"""Samples that the share is measured on."""


class FrameReader:
    """Makes an image of rows of a frame: linear counts are left as they are, all others become amplitudes.

    Where there are samples without data, or most are of few counts, the image is written: gaps are filled, and counts
    are dithered. Else a step of one count would be taken for an echo where all around is the same count.
    """

    def __init__(self, layout: ImageLayout, buffers: DoubleBuffer) -> None:
        self._buffers = buffers
        self._of_gain_1 = of_gain_1(buffers.back)
        self._stride, self._offset = layout.stride, mean_offset(layout.stride)
        self._columns = [
            Decimation(int(layout.origin[band.columns.start]), layout.stride, band.columns.start, band.columns.stop)
            for band in layout.bands
        ]
        self._averaged: dict[np.dtype[np.generic], AnyArray] = {}
        self._drawn = draw()

    def read(self, rows: AnyArray, scale: SampleScale, missing: Mask, number: int) -> GainedImage:
        """Return the image of rows (beams, all samples); it may share their memory.

        missing: (beams, columns) cells without data, or `ALL_DATA`. number: of the ping.
        """
        image = self._read(rows, scale)
        quiet = self._counts(rows, scale) and share_of_zeros(rows, self._columns[0].first, _LOOKED_AT) > _QUIET
        if not quiet and not missing.size:
            return image
        image = self._buffers.apply(image)
        if quiet:
            dither(self._buffers.front, self._drawn, number)
        if missing.size:
            fill_gaps(self._buffers.front, missing, self._drawn, number)
        return image

    def _counts(self, rows: AnyArray, scale: SampleScale) -> bool:
        return scale.scale == "linear" and rows.dtype.kind == "u"

    def _read(self, rows: AnyArray, scale: SampleScale) -> GainedImage:
        self._buffers.restart()
        if not self._counts(rows, scale):
            for columns in self._columns:
                to_amplitude(rows, columns, scale, self._buffers.back)
            return self._buffers.flip()
        if self._stride == len(self._columns) == 1:
            return self._of_gain_1.with_cells(rows, self._columns[0].first, self._offset)
        return self._of_gain_1.with_cells(self._averaged_counts(rows), 0, self._offset)

    def _averaged_counts(self, rows: AnyArray) -> AnyArray:
        if rows.dtype not in self._averaged:
            self._averaged[rows.dtype] = np.empty(self._buffers.back.shape, rows.dtype)
        counts = self._averaged[rows.dtype]
        for columns in self._columns:
            average_counts(rows, columns, counts)
        return counts
