"""Cell-averaging and order-statistic CFAR along the beam, with the two levels measured instead of assumed."""

from collections.abc import Iterable
from itertools import islice

import numpy as np

from ods.base.arrays import Floats, Floats32, Image
from ods.base.kernel import kernel
from ods.pipeline.detect.levels import Grouping
from ods.pipeline.detect.noise import Learner, NoiseMeter
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.padding import mirrored
from ods.pipeline.image.regions import Regions
from ods.pipeline.stage.params import CfarParams
from ods.pipeline.stage.registry import DetectStep, detect_stage

_METHODS = ("ca", "goca", "soca", "os")
_HALVINGS = 12
"""Steps of the search for an order statistic: it is then known to about 0.1 % of the surroundings' mean."""


@detect_stage("detect.cfar", CfarParams)
def cfar(params: CfarParams, fan: Fan) -> DetectStep:
    """Find regions in the image divided by the level of each cell's surroundings.

    CA: M. Finn, R. S. Johnson, 1968; GOCA: V. G. Hansen, 1973; SOCA: G. V. Trunk, 1978; OS: H. Rohling, 1983.
    """
    meter = NoiseMeter()
    group = Grouping(params, fan)
    ratio = np.empty(fan.shape, np.float32)
    reach = params.guard + params.train
    sums = np.empty(fan.samples + 2 * reach + 2, np.float64)
    padded = np.empty(fan.samples + 2 * reach, np.float32)
    work = np.empty((3, fan.samples), np.float32)
    method = _METHODS.index(params.method)

    def divided(image: Image, middle: float) -> Image:
        floor = np.float32(0.05 * middle)
        divide_by_surroundings(image, method, params.guard, params.train, params.rank, floor, sums, padded, work, ratio)
        return ratio

    def learn(images: Iterable[Image]) -> None:
        some = islice(images, 0, None, 4) if params.method == "os" else images  # ordering takes ten times as long
        meter.learn(divided(image, meter.background_and_noise(image)[0]) for image in some)

    def step(image: Image) -> Regions:
        middle, _ = meter.background_and_noise(image)
        if middle <= 0.0:
            return group.nothing()
        divided(image, middle)
        background, noise = meter.background_and_noise(ratio)
        high = meter.level_of_rate(ratio, params.rate)
        low = min(background + params.low * max(noise, 0.02 * background), high)
        found = group.regions(ratio, low, high, background)
        return found._replace(background=middle)

    return Learner(step, learn)


@kernel
def divide_by_surroundings(
    image: Image,
    method: int,
    guard: int,
    train: int,
    rank: float,
    floor: np.float32,
    sums: Floats,
    padded: Floats32,
    work: Image,
    out: Image,
) -> None:
    """Fill out with image (beams, samples) over the level of each cell's surroundings, at least `floor`.

    sums (samples + 2 reach + 1,), padded (samples + 2 reach,), reach = guard + train, and work (3, samples) are work
    space.
    """
    samples = image.shape[1]
    reach = guard + train
    for b in range(image.shape[0]):
        for i in range(samples + 2 * reach):
            padded[i] = image[b, mirrored(i - reach, samples)]
        sums[0] = 0.0
        for i in range(samples + 2 * reach):
            sums[i + 1] = sums[i] + padded[i]
        if method == 3:
            _ordered(padded, sums, guard, train, rank, floor, work, out[b])
        else:
            _averaged(sums, method, guard, train, floor, out[b])
        for j in range(samples):
            out[b, j] = image[b, j] / out[b, j]


@kernel
def _averaged(sums: Floats, method: int, guard: int, train: int, floor: np.float32, out: Floats32) -> None:
    reach = guard + train
    for j in range(out.size):
        near = np.float32((sums[j + train] - sums[j]) / train)
        far = np.float32((sums[j + 2 * reach + 1] - sums[j + reach + guard + 1]) / train)
        level = np.float32(0.5) * (near + far)
        if method == 1:
            level = max(near, far)
        elif method == 2:
            level = min(near, far)
        out[j] = max(level, floor)


@kernel
def _ordered(
    padded: Floats32,
    sums: Floats,
    guard: int,
    train: int,
    rank: float,
    floor: np.float32,
    work: Image,
    out: Floats32,
) -> None:
    """Fill out with the quantile `rank` of the cells around, by halving an interval for the whole row at once.

    At most total / most cells that are not negative can reach a level that `most` of them reach. work: (3, samples).
    """
    low, high, count = work[0], work[1], work[2]
    behind = guard + train + guard + 1
    most = np.float32(max(2.0 * train * (1.0 - rank), 1.0))
    for j in range(out.size):
        low[j] = np.float32(0.0)
        high[j] = np.float32(sums[j + train] - sums[j] + sums[j + behind + train] - sums[j + behind]) / most
    for _ in range(_HALVINGS):
        for j in range(out.size):
            out[j], count[j] = np.float32(0.5) * (low[j] + high[j]), np.float32(0.0)
        for k in range(train):
            _count_above(padded[k : k + out.size], out, count)
            _count_above(padded[behind + k : behind + k + out.size], out, count)
        for j in range(out.size):
            above = count[j] >= most
            low[j], high[j] = out[j] if above else low[j], high[j] if above else out[j]
    for j in range(out.size):
        out[j] = max(np.float32(0.5) * (low[j] + high[j]), floor)


@kernel
def _count_above(cells: Floats32, level: Floats32, count: Floats32) -> None:
    for j in range(count.size):
        count[j] += np.float32(1.0) if cells[j] > level[j] else np.float32(0.0)
