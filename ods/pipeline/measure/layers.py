"""Smooth functions of a few numbers that were fitted to examples: two layers, the first of which saturates.

The outputs are sums of hyperbolic tangents of sums of the inputs, so that beyond the examples they stay finite.
"""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import kernel
from ods.pipeline.measure.features import Features


@kernel
def outputs_of(inputs: Features, hidden: Floats, out: Floats) -> Floats:
    """Return the outputs, (m,). hidden: (inputs + 1, n) factors, the last row the constants; out: (n + 1, m) alike."""
    count, last = hidden.shape[1], hidden.shape[0] - 1
    sums = np.empty(out.shape[1])
    for k in range(sums.size):
        sums[k] = out[count, k]
    for j in range(count):
        total = hidden[last, j]
        for i in range(len(inputs)):
            total += inputs[i] * hidden[i, j]
        bent = math.tanh(total)
        for k in range(sums.size):
            sums[k] += bent * out[j, k]
    return sums
