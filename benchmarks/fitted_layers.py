"""Fit functions of two layers (ods/pipeline/measure/layers.py) to examples, by any loss whose slope is known."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from ods.base.arrays import Floats, Ints

Loss = Callable[[Floats], tuple[Floats, Floats]]
"""From outputs (examples, m) to the loss of each example, (examples,), and its slopes, (examples, m)."""
HIDDEN = 20
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
        """Return the outputs for examples (n, inputs): (n, outputs)."""
        bent = np.tanh(inputs @ self.hidden[:-1] + self.hidden[-1])
        return np.asarray(bent @ self.out[:-1] + self.out[-1])


def fitted(inputs: Floats, loss: Loss, begin: Layers, weights: Floats, ridge: float, rounds: int) -> Layers:
    """Return the layers whose weighted mean loss, with a penalty for large factors, is least near `begin`.

    The penalty is on factors of inputs in units of their standard deviations.
    """
    mean, scale = inputs.mean(0), inputs.std(0) + 1e-9
    scaled, share = (inputs - mean) / scale, weights / weights.sum()
    shapes = begin.hidden.shape, begin.out.shape
    split = begin.hidden.size

    def layers(x: Floats) -> Layers:
        return Layers(x[:split].reshape(shapes[0]), x[split:].reshape(shapes[1]))

    def cost(x: Floats) -> tuple[float, Floats]:
        now = layers(x)
        bent = np.tanh(scaled @ now.hidden[:-1] + now.hidden[-1])
        value, slope = loss(bent @ now.out[:-1] + now.out[-1])
        slope = slope * share[:, None]
        back = slope @ now.out[:-1].T * (1.0 - bent**2)
        slopes = np.concatenate((
            (np.vstack((scaled.T @ back, back.sum(0)))).ravel(), np.vstack((bent.T @ slope, slope.sum(0))).ravel(),
        ))  # fmt: skip
        held = np.concatenate([np.vstack((part[:-1], 0.0 * part[-1:])).ravel() for part in now])
        return float(share @ value + 0.5 * ridge * held @ held), slopes + ridge * held

    first = np.vstack((begin.hidden[:-1] * scale[:, None], begin.hidden[-1] + mean @ begin.hidden[:-1]))
    best = layers(
        minimize(
            cost, np.concatenate((first.ravel(), begin.out.ravel())),
            jac=True, method="L-BFGS-B", options={"maxiter": rounds},
        ).x
    )  # fmt: skip
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


def kind_loss(kind: Ints, count: int) -> Loss:
    """Return the logarithmic loss of probabilities of `count` kinds. kind: the true ones, (examples,)."""
    truth = np.eye(count)[kind]

    def loss(outputs: Floats) -> tuple[Floats, Floats]:
        likely = np.exp(outputs - outputs.max(1, keepdims=True))
        likely /= likely.sum(1, keepdims=True)
        return -np.log((likely * truth).sum(1) + 1e-12), likely - truth

    return loss


def distance_loss(truth: Floats, counts: Floats, bend: float) -> Loss:
    """Return half the squared distance to the truth, and beyond `bend` as it goes on straight (P. J. Huber 1964).

    counts: how much each output of each example counts.
    """

    def loss(outputs: Floats) -> tuple[Floats, Floats]:
        away = outputs - truth
        inside = np.clip(away, -bend, bend)
        return (counts * inside * (away - 0.5 * inside)).sum(1), counts * inside

    return loss


def variance_loss(error: Floats) -> Loss:
    """Return log(v) + e^2/v of variances v, of which the outputs are the logarithms (a gamma regression).

    P. McCullagh, J. A. Nelder, Generalized Linear Models, 1989, chapter 10: where its sum is least, e^2/v is 1 on
    average. Squares over MOST_SQUARE go on as their logarithm.
    """

    def loss(outputs: Floats) -> tuple[Floats, Floats]:
        logarithm = np.clip(outputs, -20.0, 20.0)
        square = error**2 / np.exp(logarithm)
        inside = np.minimum(square, MOST_SQUARE)
        beyond = MOST_SQUARE * np.log(np.maximum(square, MOST_SQUARE) / MOST_SQUARE)
        return (inside + beyond + logarithm).sum(1), 1.0 - inside

    return loss
