"""The fit of the laws of circles, on data drawn by known ones, and what they say of shapes at the border of sense."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import circle_laws
from benchmarks.fitted_layers import (
    Layers,
    Loss,
    beginning,
    distance_loss,
    fitted,
    kind_loss,
    variance_loss,
)
from ods.base.arrays import Floats
from ods.pipeline.measure import laws
from ods.pipeline.measure.circle import circle_of
from ods.pipeline.measure.depth import Depth
from ods.pipeline.measure.features import Features, features_of
from ods.pipeline.measure.kinds import kinds_of
from ods.pipeline.measure.layers import outputs_of
from ods.pipeline.measure.shape import Shape

BODY, SIGMAS = Layers(laws.BODY_HIDDEN, laws.BODY_OUT), Layers(laws.SIGMAS_HIDDEN, laws.SIGMAS_OUT)


def fit(inputs: Floats, loss: Loss, outputs: int) -> Layers:
    """Fit without a penalty to speak of, all examples alike."""
    rng = np.random.default_rng(1)
    return fitted(inputs, loss, beginning(inputs, outputs, rng), np.ones(len(inputs)), 1e-5, 150)


def drawn(rng: np.random.Generator, count: int = 4000) -> Floats:
    """Return inputs, (count, 2)."""
    return np.column_stack((5.0 + rng.normal(size=count), rng.uniform(-0.1, 0.1, count)))


def test_variances_are_found_again_from_errors_of_them() -> None:
    rng = np.random.default_rng(1)
    inputs = drawn(rng)
    logarithm = np.column_stack((np.sin(inputs[:, 0]), 10.0 * inputs[:, 1] - 3.0))
    error = np.exp(0.5 * logarithm) * rng.normal(size=logarithm.shape)
    law = fit(inputs, variance_loss(error), 2)
    assert np.sqrt(np.mean((law.outputs(inputs) - logarithm) ** 2)) < 0.2
    assert np.mean(error**2 / np.exp(law.outputs(inputs)), axis=0) == pytest.approx([1.0, 1.0], abs=0.02)


def test_probabilities_of_kinds_are_found_again_from_kinds_drawn() -> None:
    rng = np.random.default_rng(2)
    inputs = drawn(rng)
    likely = np.exp(np.column_stack((inputs[:, 0] - 5.0, 20.0 * inputs[:, 1], np.zeros(len(inputs)))))
    likely /= likely.sum(1, keepdims=True)
    kind = (rng.random(len(inputs))[:, None] > np.cumsum(likely, axis=1)).sum(1)
    told = np.exp(fit(inputs, kind_loss(kind, 3), 3).outputs(inputs))
    assert np.abs(told / told.sum(1, keepdims=True) - likely).mean() < 0.04


def test_a_distance_is_found_in_spite_of_a_few_that_are_far_off_and_only_where_it_counts() -> None:
    rng = np.random.default_rng(3)
    inputs = drawn(rng)
    truth = np.column_stack((inputs[:, 0] ** 2 / 25.0, inputs[:, 1])) + 0.02 * rng.normal(size=inputs.shape)
    seen, counts = truth.copy(), np.ones(truth.shape)
    seen[:40, 0] += 30.0
    seen[100:2000, 1], counts[100:2000, 1] = 5.0, 0.0
    law = fit(inputs, distance_loss(seen, counts, 0.1), 2)
    assert np.abs(law.outputs(inputs) - truth).mean() < 0.03


def test_slopes_of_losses_are_those_of_their_values() -> None:
    rng = np.random.default_rng(4)
    outputs = 2.0 * rng.normal(size=(50, 3))
    losses = (
        kind_loss(rng.integers(0, 3, 50), 3),
        distance_loss(rng.normal(size=(50, 3)), rng.uniform(0.0, 2.0, (50, 3)), 0.5),
        variance_loss(3.0 * rng.normal(size=(50, 3))),
    )
    for loss in losses:
        for k in range(3):
            step = 1e-6 * np.eye(3)[k]
            slope = (loss(outputs + step)[0] - loss(outputs - step)[0]) / 2e-6
            assert loss(outputs)[1][:, k] == pytest.approx(slope, abs=1e-5)


def test_the_module_is_as_the_command_writes_it() -> None:
    assert Path(laws.__file__).read_text() == circle_laws.module_of({"BODY": BODY, "SIGMAS": SIGMAS})


def test_kernel_and_numpy_have_the_same_outputs() -> None:
    inputs = np.random.default_rng(5).normal(size=(20, len(Features._fields)))
    for law in (BODY, SIGMAS):
        told = [outputs_of(Features(*row.tolist()), law.hidden, law.out) for row in inputs]
        assert np.array(told) == pytest.approx(law.outputs(inputs), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("long", [0.0, 0.2, 3.0, 300.0])
@pytest.mark.parametrize("wide", [0.0, 1.0, 500.0])
@pytest.mark.parametrize("peak", [0.1, 4.0, 1e6])
def test_of_any_shape_probabilities_have_the_sum_1_and_sigmas_are_finite(long: float, wide: float, peak: float) -> None:
    for point, beams in ((0.02, 1), (0.2, 40)):
        depth = Depth(20.0, 20.0 + long, 0.5, peak, 1.0, point)
        shape = Shape(depth, wide, 0.5, 0.5 * wide, 0.5 * long, 0.1, 0.5, beams, peak, False)
        told = outputs_of(features_of(shape), laws.BODY_HIDDEN, laws.BODY_OUT)
        assert sum(kinds_of(shape, told)) == pytest.approx(1.0)
        circle = circle_of(shape)
        assert np.isfinite(circle).all()
        assert min(circle.sigma_near_m, circle.sigma_range_m, circle.sigma_radius_m, circle.sigma_bearing_rad) > 0.0
