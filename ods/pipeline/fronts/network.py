"""A small convolutional network, learnt from simulated beds and bodies by `benchmarks.detection.train_fronts`.

Three layers that see how levels change along the range and across the beams, and two that weigh what they saw. Why no
single number does it, and how well this one does: docs/decisions/0020-fronts-by-a-network.md.
"""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats32
from ods.compiled import native

WEIGHTS = Path(__file__).with_name("network.npz")
DB = 10.0
"""Unit of its input levels, dB."""
_LINE = 64
"""Bytes of a cache line."""


class Dense(NamedTuple):
    """Weights of all values of the layer before."""

    weights: Floats32
    """(in, out)"""
    bias: Floats32
    """(out,)"""


class Convolution(NamedTuple):
    """Weights by which a layer sees the one before, around each of its places; beyond that there are zeros."""

    dense: Dense
    """in: beams, cells and channels, in this order."""
    around: tuple[int, int]
    """Beams and cells that are seen of each place,"""
    step: tuple[int, int]
    """and from one place to the next."""


class Network(NamedTuple):
    """The layers. What is below 0 behind any but the last counts as 0; each of those has a multiple of 16 outputs."""

    convolutions: tuple[Convolution, ...]
    hidden: Dense
    last: Dense

    def scores(self, windows: Floats32) -> Floats32:
        """Return the logarithm of the odds of a body's front against the bed's, where both are as frequent: (n,).

        windows: (n, BEAMS, CELLS) float32 levels, dB, of `ods.pipeline.fronts.judge`.
        """
        scores = np.empty(len(windows), np.float32)
        native.score_fronts(windows, DB, self, scores)
        return scores


def network_of(arrays: Mapping[str, Floats32]) -> Network:
    """Return the network of arrays as `benchmarks.detection.train_fronts` keeps them.

    `steps`: (convolutions, 2) beams and cells from one place to the next; `convolution0`, ...: (beams, cells, in, out);
    `hidden`, `last`: (in, out); each with a `..._bias` (out,).
    """

    def dense(name: str) -> Dense:
        weights = arrays[name]
        return Dense(_aligned(weights.reshape(-1, weights.shape[-1])), arrays[f"{name}_bias"])

    steps = [(beams, cells) for beams, cells in arrays["steps"].astype(int).tolist()]
    names = [f"convolution{k}" for k in range(len(steps))]
    around = [(arrays[name].shape[0], arrays[name].shape[1]) for name in names]
    layers = zip(map(dense, names), around, steps, strict=True)
    return Network(tuple(Convolution(*layer) for layer in layers), dense("hidden"), dense("last"))


def _aligned(weights: Floats32) -> Floats32:
    """Return a copy that begins with a cache line: it is read a fifth faster."""
    room = np.empty(weights.size + _LINE // weights.itemsize, np.float32)
    first = -room.ctypes.data % _LINE // weights.itemsize
    aligned = room[first : first + weights.size].reshape(weights.shape)
    aligned[:] = weights
    return aligned


@cache
def learnt() -> Network:
    """Return the network that comes with ODS."""
    with np.load(WEIGHTS) as arrays:
        return network_of(dict(arrays))
