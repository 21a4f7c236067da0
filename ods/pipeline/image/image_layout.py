"""Rows and ranges of a frame that make an image: focus of attention lays rings of ranges side by side."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Ints
from ods.pipeline.image.fan import Fan
from ods.pipeline.settings import AttentionSettings

MAX_RANGE = 1e6
"""Stands for 'as far as the image reaches', m."""


@dataclass(frozen=True, eq=False)
class RangeBand:
    """Ranges that fill some columns of an image. Positions are given as if the image continued like this on both
    sides."""

    columns: slice
    fan: Fan
    """Where the image's cells would lie."""
    first: int
    """Samples of the frame before column 0 of the image; negative where other ranges take those columns."""
    from_m: float
    """It answers for echoes from here"""
    to_m: float
    """to here; the rest is margin."""


@dataclass(frozen=True, eq=False)
class ImageLayout:
    """Contents of an image: rows and columns of the frame that are processed together."""

    fan: Fan
    rows: slice
    stride: int
    """Range samples that make one column."""
    bands: list[RangeBand]
    """One, or two side by side."""
    phase: int | None
    """The ping, modulo the number of phases, at which it is processed; None: each."""

    @cached_property
    def origin(self) -> Ints:
        """Return, (columns,), the first sample of the frame that makes each column."""
        column = np.arange(self.fan.samples)
        origin = self.bands[0].first + self.stride * column
        for band in self.bands[1:]:
            origin[band.columns] = band.first + self.stride * column[band.columns]
        return origin


class RangeInterval(NamedTuple):
    """A ring of ranges, m."""

    from_m: float
    to_m: float


def rings_of(fan: Fan, attention: AttentionSettings) -> list[list[RangeInterval]]:
    """Return, for each phase, the rings that are processed, near first [SSIE, focus of attention]."""
    end = fan.range0_m + fan.samples * fan.dr_m
    if not max(0.0, fan.range0_m) < attention.near_m < end or attention.every == 1:
        return [[RangeInterval(0.0, math.inf)]]
    borders = [*np.linspace(attention.near_m, end, attention.every + 1)[:-1].tolist(), math.inf]
    near = RangeInterval(0.0, attention.near_m)
    return [[near, RangeInterval(begin, stop)] for begin, stop in pairwise(borders)]


def scheduled(phases: list[list[RangeInterval]], *, apart: bool) -> list[tuple[list[RangeInterval], int | None]]:
    """Return the rings that share an image, and the image's phase; rings that touch are one."""
    if len(phases) == 1:
        return [(phases[0], None)]
    if apart:
        return [(phases[0][:1], None), *(([far], phase) for phase, (_, far) in enumerate(phases))]
    near, far = phases[0]
    return [
        ([RangeInterval(near.from_m, far.to_m)], 0),
        *((rings, phase) for phase, rings in enumerate(phases) if phase),
    ]


def layout(
    fan: Fan, rows: slice, first: int, rings: list[RangeInterval], attention: AttentionSettings, phase: int | None
) -> ImageLayout:
    """Lay rings and their margins side by side. fan, first: of the whole plane."""
    stride = min(attention.subsample, fan.samples)
    margin = attention.margin_m
    dr = stride * fan.dr_m
    bands: list[RangeBand] = []
    filled = 0
    for ring in rings:
        begin = max(0, math.floor((ring.from_m - margin - fan.range0_m) / fan.dr_m))
        stop = min(fan.samples, math.ceil(min((ring.to_m + margin - fan.range0_m) / fan.dr_m, MAX_RANGE)))
        count = max(1, (stop - begin) // stride)
        before = min(begin, fan.samples - count * stride) - filled * stride
        range0 = fan.range0_m + (before + 0.5 * (stride - 1)) * fan.dr_m
        columns = slice(filled, filled + count)
        bands.append(RangeBand(columns, replace(fan, samples=filled + count, range0_m=range0, dr_m=dr),
                          first + before, ring.from_m, ring.to_m))  # fmt: skip
        filled += count
    whole = replace(bands[0].fan, samples=filled)
    if len(bands) > 1:
        skipped = bands[1].fan.range0_m - bands[0].fan.range0_m
        whole = replace(whole, seam=bands[1].columns.start, skipped_m=skipped)
    return ImageLayout(whole, rows, stride, bands, phase)
