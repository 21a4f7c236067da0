"""Recorded samples as the first stage gets them."""

import numpy as np

from ods.base.arrays import AnyArray
from ods.pipeline.image.amplitude import Decimation, SampleScale, average_counts, mean_offset, to_amplitude
from ods.pipeline.image.double_buffer import DoubleBuffer
from ods.pipeline.image.gained_image import GainedImage, of_gain_1
from ods.pipeline.image_layout import ImageLayout


class FrameReader:
    """Makes an image of rows of a frame: linear counts are left as they are, all others become amplitudes."""

    def __init__(self, layout: ImageLayout, buffers: DoubleBuffer) -> None:
        self._buffers = buffers
        self._of_gain_1 = of_gain_1(buffers.back)
        self._stride, self._offset = layout.stride, mean_offset(layout.stride)
        self._columns = [
            Decimation(int(layout.origin[band.columns.start]), layout.stride, band.columns.start, band.columns.stop)
            for band in layout.bands
        ]
        self._averaged: dict[np.dtype[np.generic], AnyArray] = {}

    def read(self, rows: AnyArray, scale: SampleScale) -> GainedImage:
        """Return the image of rows (beams, all samples); it may share their memory."""
        self._buffers.restart()
        if scale.scale != "linear" or rows.dtype.kind != "u":
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
