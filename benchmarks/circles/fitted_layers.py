"""Fit the law of standard deviations (ods/pipeline/measure/sigmas/sigmas.h) to examples of errors."""

from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from ods.base.arrays import Floats

HIDDEN = 24
"""Numbers in the first layer."""
MOST_SQUARE = 16.0
"""Squares of errors over their variances count no more than that: the square of the tracker's gate."""


class Layers(NamedTuple):
    """Factors, the last row of each the constants."""

    hidden: Floats
    """(inputs + 1, HIDDEN)."""
    out: Floats
    """(HIDDEN + 1, outputs)."""

    def outputs(self, inputs: Floats) -> Floats:
        """Return the logarithms of variances for examples (n, inputs): (n, outputs)."""
        bent = np.tanh(inputs @ self.hidden[:-1] + self.hidden[-1])
        return np.asarray(bent @ self.out[:-1] + self.out[-1])


def fitted(inputs: Floats, errors: Floats, begin: Layers, ridge: float, rounds: int) -> Layers:
    """Return the layers near `begin` of which the variances' mean loss, with a penalty for large factors, is least.

    inputs: (n, inputs); errors: (n, outputs). The penalty is on factors of inputs in units of their standard
    deviations.
    """
    mean, scale = inputs.mean(0), inputs.std(0) + 1e-9
    scaled = (inputs - mean) / scale
    shapes, split = (begin.hidden.shape, begin.out.shape), begin.hidden.size

    def layers(x: Floats) -> Layers:
        return Layers(x[:split].reshape(shapes[0]), x[split:].reshape(shapes[1]))

    def cost(x: Floats) -> tuple[float, Floats]:
        now = layers(x)
        bent = np.tanh(scaled @ now.hidden[:-1] + now.hidden[-1])
        value, slope = variance_loss(errors, bent @ now.out[:-1] + now.out[-1])
        slope = slope / len(inputs)
        back = slope @ now.out[:-1].T * (1.0 - bent**2)
        slopes = np.concatenate((
            (np.vstack((scaled.T @ back, back.sum(0)))).ravel(), np.vstack((bent.T @ slope, slope.sum(0))).ravel(),
        ))  # fmt: skip
        held = np.concatenate([np.vstack((part[:-1], 0.0 * part[-1:])).ravel() for part in now])
        return float(value.sum() / len(inputs) + 0.5 * ridge * held @ held), slopes + ridge * held

    first = np.vstack((begin.hidden[:-1] * scale[:, None], begin.hidden[-1] + mean @ begin.hidden[:-1]))
    start = np.concatenate((first.ravel(), begin.out.ravel()))
    best = layers(minimize(cost, start, jac=True, method="L-BFGS-B", options={"maxiter": rounds}).x)
    plain = best.hidden[:-1] / scale[:, None]
    return Layers(np.vstack((plain, best.hidden[-1] - mean @ plain)), best.out)


def beginning(inputs: Floats, outputs: int, rng: np.random.Generator) -> Layers:
    """Return small factors drawn at random."""
    count = inputs.shape[1]
    plain = rng.normal(0.0, 1.0 / np.sqrt(count), (count, HIDDEN)) / (inputs.std(0) + 1e-9)[:, None]
    return Layers(
        np.vstack((plain, -inputs.mean(0) @ plain)),
        np.vstack((rng.normal(0.0, 0.1, (HIDDEN, outputs)), np.zeros(outputs))),
    )


def variance_loss(errors: Floats, outputs: Floats) -> tuple[Floats, Floats]:
    """Return log(v) + e^2/v of variances v, of which the outputs are the logarithms, and its slopes, (n, outputs) each.

    P. McCullagh, J. A. Nelder, Generalized Linear Models, 1989, chapter 8: where its sum is least, e^2/v is 1 on
    average. Squares over MOST_SQUARE go on as their logarithm.
    """
    logarithm = np.clip(outputs, -20.0, 20.0)
    square = errors**2 / np.exp(logarithm)
    inside = np.minimum(square, MOST_SQUARE)
    beyond = MOST_SQUARE * np.log(np.maximum(square, MOST_SQUARE) / MOST_SQUARE)
    return inside + beyond + logarithm, 1.0 - inside
