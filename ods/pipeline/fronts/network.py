"""A small convolutional network, learnt from simulated beds and bodies by `benchmarks.train_fronts`.

Three layers that see how levels change along the range and across the beams, and two that weigh what they saw. Why no
single number does it, and how well this one does: docs/decisions/0020-fronts-by-a-network.md.
"""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ods.base.arrays import Floats32

WEIGHTS = Path(__file__).with_name("network.npz")
STEPS = ((1, 2), (2, 2), (1, 2))
"""Beams and cells from one place to the next, of each convolution."""
DB = np.float32(10.0)
"""Levels are given to it in units of so many dB."""


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
    """The layers. What is below 0 behind any but the last counts as 0."""

    convolutions: tuple[Convolution, ...]
    hidden: Dense
    last: Dense

    def scores(self, windows: Floats32) -> Floats32:
        """Return the logarithm of the odds of a body's front against the bed's, where both are as frequent: (n,).

        windows: (n, BEAMS, CELLS) float32 levels, dB, of `ods.pipeline.fronts.windows`.
        """
        seen = (windows / DB)[..., None]
        for layer in self.convolutions:
            seen = _convolved(seen, layer)
        return _weighed(_weighed(seen.reshape(len(seen), -1), self.hidden, least=0.0), self.last)[:, 0]


def _convolved(seen: Floats32, layer: Convolution) -> Floats32:
    """Return what a layer makes of seen (n, beams, cells, in): (n, beams, cells, out)."""
    beams, cells = layer.around
    padded = np.pad(seen, ((0, 0), (beams // 2, beams // 2), (cells // 2, cells // 2), (0, 0)))
    around = sliding_window_view(padded, layer.around, axis=(1, 2))[:, :: layer.step[0], :: layer.step[1]]
    places = around.transpose(0, 1, 2, 4, 5, 3).reshape(*around.shape[:3], -1)
    return _weighed(places, layer.dense, least=0.0)


def _weighed(values: Floats32, layer: Dense, least: float | None = None) -> Floats32:
    made: Floats32 = values @ layer.weights
    made += layer.bias
    return made if least is None else np.maximum(made, np.float32(least), out=made)


def network_of(arrays: Mapping[str, Floats32]) -> Network:
    """Return the network of arrays as `benchmarks.train_fronts` keeps them.

    `convolution0`, ...: (beams, cells, in, out); `hidden`, `last`: (in, out); each with a `..._bias` (out,).
    """

    def dense(name: str) -> Dense:
        weights = arrays[name]
        return Dense(np.ascontiguousarray(weights.reshape(-1, weights.shape[-1])), arrays[f"{name}_bias"])

    names = [f"convolution{k}" for k in range(len(STEPS))]
    around = [(arrays[name].shape[0], arrays[name].shape[1]) for name in names]
    layers = zip(map(dense, names), around, STEPS, strict=True)
    return Network(tuple(Convolution(*layer) for layer in layers), dense("hidden"), dense("last"))


@cache
def learnt() -> Network:
    """Return the network that comes with ODS."""
    with np.load(WEIGHTS) as arrays:
        return network_of(dict(arrays))
