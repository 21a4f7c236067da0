"""Cell-averaging and order-statistic CFAR along the beam, with the two levels measured instead of assumed."""

from collections.abc import Iterable, Iterator
from itertools import islice
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32, Image
from ods.compiled.kernel import kernel
from ods.pipeline.detect.grouping import DetectionLevels, Grouping
from ods.pipeline.detect.noise import NoiseMeter
from ods.pipeline.detect.tail import TailMeter
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.padding import mirrored
from ods.pipeline.image.recorded import Recorded
from ods.pipeline.image.regions import Regions
from ods.pipeline.stage.params import CfarParams
from ods.pipeline.stage.registry import detect_stage
from ods.pipeline.stage.step import PreparedDetector

_METHODS = ("ca", "goca", "soca", "os")
_HALVINGS = 12
"""Steps of the search for an order statistic: it is then known to about 0.1 % of the surroundings' mean."""
_LEAST = np.float32(0.05)
"""Least level, in units of the whole image's."""


@detect_stage("detect.cfar", CfarParams)
def cfar(params: CfarParams, fan: Fan) -> PreparedDetector:
    """Find regions in the image divided by the level of each cell's surroundings.

    CA: M. Finn, R. S. Johnson, 1968; GOCA: V. G. Hansen, 1973; SOCA: G. V. Trunk, 1978; OS: H. Rohling, 1983.
    """
    meter, tail = NoiseMeter(), TailMeter(params.rate)
    group = Grouping(params, fan)
    ratio = np.empty(fan.shape, np.float32)
    around = CfarWindow(_METHODS.index(params.method), params.guard, params.train, params.rank)
    work = _work(around, fan.samples)

    def divided(image: Image, middle: float) -> Image:
        divide_by_surroundings(image, around, np.float32(middle), work, ratio)
        return ratio

    def ratios(images: Iterable[Image]) -> Iterator[Image]:
        some = islice(images, 0, None, 4) if params.method == "os" else images  # ordering takes ten times as long
        return (divided(image, meter.background_and_noise(image)[0]) for image in some)

    def learn(kinds: Iterable[Iterable[Image]]) -> None:
        tail.learn(ratios(images) for images in kinds)

    def find(image: Image, recorded: Recorded) -> Regions:
        middle, _ = meter.background_and_noise(image)
        if middle <= 0.0:
            return group.nothing(image)
        divided(image, middle)
        background, noise = meter.background_and_noise(ratio)
        if background <= 0.0:
            return group.nothing(ratio)
        high = tail.level(ratio, background, noise)
        low = min(background + params.low * max(noise, 0.02 * background), high)
        found = group.regions(ratio, recorded, DetectionLevels(low, high, background))
        return found._replace(background=middle)

    return PreparedDetector(find, learn, refuses_nan=True)


class CfarWindow(NamedTuple):
    """The cells that tell the level around a cell, and how they tell it."""

    method: int
    """Place in `_METHODS`."""
    guard: int
    """Samples on each side of a cell that do not count,"""
    train: int
    """and beyond them, that do."""
    rank: float
    """os: quantile of the surroundings that is taken."""


class CfarWork(NamedTuple):
    """Work space; reach = guard + train."""

    sums: Floats
    """(samples + 2 reach + 1,) running sums of the padded row,"""
    held: Floats
    """and of how many of its cells hold data: are above 0."""
    padded: Floats32
    """(samples + 2 reach,)."""
    rows: Image
    """(4, samples)."""


def _work(around: CfarWindow, samples: int) -> CfarWork:
    padded = samples + 2 * (around.guard + around.train)
    sums = np.empty((2, padded + 1))
    return CfarWork(sums[0], sums[1], np.empty(padded, np.float32), np.empty((4, samples), np.float32))


@kernel
def divide_by_surroundings(image: Image, around: CfarWindow, middle: np.float32, work: CfarWork, out: Image) -> None:
    """Fill out with image (beams, samples) over the level of each cell's surroundings, at least 1/20 of `middle`.

    Cells of 0 hold no data and do not count; where there are no others around, the level is `middle`.
    """
    sums, held, padded = work.sums, work.held, work.padded
    samples = image.shape[1]
    reach = around.guard + around.train
    for b in range(image.shape[0]):
        for i in range(samples + 2 * reach):
            padded[i] = image[b, mirrored(i - reach, samples)]
        sums[0], held[0] = 0.0, 0.0
        for i in range(samples + 2 * reach):
            sums[i + 1] = sums[i] + padded[i]
            held[i + 1] = held[i] + (0.0 if padded[i] == np.float32(0.0) else 1.0)
        if around.method == 3:
            _ordered(work, around, middle, out[b])
        else:
            _averaged(work, around, middle, out[b])
        for j in range(samples):
            out[b, j] = image[b, j] / out[b, j]


@kernel
def _averaged(work: CfarWork, around: CfarWindow, middle: np.float32, out: Floats32) -> None:
    method, guard, train, sums, held = around.method, around.guard, around.train, work.sums, work.held
    reach = guard + train
    behind = reach + guard + 1
    for j in range(out.size):
        near_count, far_count = held[j + train] - held[j], held[j + behind + train] - held[j + behind]
        near_sum, far_sum = sums[j + train] - sums[j], sums[j + behind + train] - sums[j + behind]
        level = (near_sum + far_sum) / (near_count + far_count) if near_count + far_count > 0.0 else middle
        if method != 0 and near_count > 0.0 and far_count > 0.0:
            near, far = near_sum / near_count, far_sum / far_count
            level = max(near, far) if method == 1 else min(near, far)
        out[j] = max(np.float32(level), _LEAST * middle)


@kernel
def _ordered(work: CfarWork, around: CfarWindow, middle: np.float32, out: Floats32) -> None:
    """Fill out with the quantile `rank` of the cells around, by halving an interval for the whole row at once.

    At most total / most cells that are not negative can reach a level that `most` of them reach.
    """
    guard, train, padded, sums, held = around.guard, around.train, work.padded, work.sums, work.held
    low, high, count, most = work.rows[0], work.rows[1], work.rows[2], work.rows[3]
    behind = guard + train + guard + 1
    for j in range(out.size):
        cells = held[j + train] - held[j] + held[j + behind + train] - held[j + behind]
        most[j] = np.float32(max(cells * (1.0 - around.rank), 1.0))
        low[j] = np.float32(0.0) if cells > 0.0 else middle
        total = np.float32(sums[j + train] - sums[j] + sums[j + behind + train] - sums[j + behind])
        high[j] = total / most[j] if cells > 0.0 else middle
    for _ in range(_HALVINGS):
        for j in range(out.size):
            out[j], count[j] = np.float32(0.5) * (low[j] + high[j]), np.float32(0.0)
        for k in range(train):
            _count_above(padded[k : k + out.size], out, count)
            _count_above(padded[behind + k : behind + k + out.size], out, count)
        for j in range(out.size):
            above = count[j] >= most[j]
            low[j], high[j] = out[j] if above else low[j], high[j] if above else out[j]
    for j in range(out.size):
        out[j] = max(np.float32(0.5) * (low[j] + high[j]), _LEAST * middle)


@kernel
def _count_above(cells: Floats32, level: Floats32, count: Floats32) -> None:
    for j in range(count.size):
        count[j] += np.float32(1.0) if cells[j] > level[j] else np.float32(0.0)
