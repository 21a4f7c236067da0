"""Random numbers as functions of what they are for: the same seed and place give the same number in any order of calls.

A 32-bit integer hash turns a key into bits, two table look-ups turn them into a normal number (random_field.h).
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from ods.base.arrays import Floats32

Keys = NDArray[np.uint32]
Normals = Floats32

BITS = 16
"""Bits of one look-up; each 32-bit hash makes two."""
MASK64 = 2**64 - 1


@cache
def normal_table() -> Normals:
    """Return 2**BITS float32 whose pairwise sums are normal: mean 0, variance 1, right to 3 % at 4.5 sigma.

    The same array each time: do not write to it.
    """
    count = 2**BITS
    edges = np.exp(-0.5 * ndtri(np.arange(1, count) / count) ** 2) / np.sqrt(2.0 * np.pi)
    density = np.concatenate([[0.0], edges, [0.0]])
    means = (density[:-1] - density[1:]) * count  # the mean of the normal variable between two quantiles
    return np.asarray(means / (means.std() * np.sqrt(2.0)), np.float32)


def bits64(seed: int, *place: int) -> int:
    """Return 64 bits that depend on the seed and on every number of the place."""
    state = seed & MASK64
    for number in place:
        state = _mix64((state ^ (number & MASK64)) + 0x9E3779B97F4A7C15)
    return _mix64(state)


def uniform(seed: int, *place: int) -> float:
    """Return a number in [0, 1)."""
    return (bits64(seed, *place) >> 11) * 2.0**-53


def normal(seed: int, *place: int) -> float:
    """Return a normal number, mean 0, variance 1."""
    return float(ndtri((bits64(seed, *place) >> 12) * 2.0**-52 + 2.0**-53))


def make_keys(seed: int, stream: int, rows: int, columns: int) -> Keys:
    """Return (rows, columns) keys, no structure among them."""
    first = bits64(seed, stream)
    counter = np.arange(rows * columns, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15) + np.uint64(first)
    for shift, factor in ((30, 0xBF58476D1CE4E5B9), (27, 0x94D049BB133111EB)):
        counter = (counter ^ (counter >> np.uint64(shift))) * np.uint64(factor)
    return (counter >> np.uint64(32)).astype(np.uint32).reshape(rows, columns)


def _mix64(state: int) -> int:
    state &= MASK64
    state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & MASK64
    state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & MASK64
    return state ^ (state >> 31)
