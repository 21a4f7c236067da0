"""Probabilities of associations against all joint events, their use against probabilistic data association."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

from ods.base.arrays import Floats, Indices
from ods.base.frames.geometry import quat_from_euler
from ods.tracker.association.assignment import Question
from ods.tracker.association.hypotheses.gating import Hypotheses
from ods.tracker.association.jpda import LEAST_GAIN, association_probabilities, probabilistic
from ods.tracker.measurement.model import PredictedMeasurement
from ods.tracker.measurement.scan import vehicle_at
from ods.tracker.named import Named
from ods.tracker.observer.belief import Estimate
from tests.tracker.samples import NO_SIGMA, SIGMA_RANGE, echoes, predicted_measurement


def hypotheses(objects: Indices, echoes: Indices, ratio: Floats) -> Hypotheses:
    """Return pairs whose score is their ratio."""
    return Hypotheses(objects, echoes, ratio, ratio)


def pairs_of(worth: Floats) -> Hypotheses:
    rows, columns = np.nonzero(np.isfinite(worth))
    return hypotheses(rows, columns, worth[rows, columns])


def exact(worth: Floats) -> Floats:
    """Return the marginals of (n, m) log-odds, nan where there is no pair, by going through all joint events."""
    n, m = worth.shape
    odds = np.exp(np.where(np.isfinite(worth), worth, -np.inf))
    marginals, total = np.zeros((n, m)), 0.0
    for event in itertools.product(range(-1, m), repeat=n):
        taken = [j for j in event if j >= 0]
        if len(taken) == len(set(taken)):
            weight = math.prod(odds[i, j] for i, j in enumerate(event) if j >= 0)
            total += weight
            for i, j in enumerate(event):
                if j >= 0:
                    marginals[i, j] += weight
    return marginals / total


def approximate(worth: Floats) -> Floats:
    found = pairs_of(worth)
    share, _ = association_probabilities(found, *worth.shape)
    result = np.zeros(worth.shape)
    result[found.objects, found.echoes] = share
    return result


def test_shares_are_near_the_marginals_of_all_joint_events() -> None:
    errors = []
    for seed in range(500):
        rng = np.random.default_rng(seed)
        worth = rng.normal(0.0, 3.0, rng.integers(1, 5, 2))
        worth[rng.random(worth.shape) < 0.4] = np.nan
        errors.append(np.abs(approximate(worth) - exact(worth)).max())
    assert np.percentile(errors, 90) < 0.01
    assert np.max(errors) < 0.2


def test_shares_are_exact_where_the_pairs_make_no_loops() -> None:
    """A chain: object 0 has echoes 0 and 1, object 1 echoes 1 and 2, object 2 echo 2 and 3."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        worth = np.full((3, 4), np.nan)
        for i in range(3):
            worth[i, i : i + 2] = rng.normal(0.0, 3.0, 2)
        np.testing.assert_allclose(approximate(worth), exact(worth), atol=2e-3)


worths = st.floats(-1e6, 1e6) | st.floats(-30.0, 30.0)


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5), worths), unique_by=lambda pair: pair[:2]))
def test_whatever_the_likelihoods_shares_are_probabilities(pairs: list[tuple[int, int, float]]) -> None:
    objects, columns = (np.array([pair[k] for pair in pairs], np.intp) for k in (0, 1))
    worth = np.array([pair[2] for pair in pairs], np.float64)
    share, free = association_probabilities(hypotheses(objects, columns, worth), 6, 6)
    for values in (share, free, np.bincount(objects, share, 6)):
        assert np.isfinite(values).all()
        assert (values >= 0.0).all()
        assert (values <= 1.0 + 1e-9).all()


def one_object(place_m: float, variance_m2: float = 0.04) -> tuple[Named[PredictedMeasurement], Estimate]:
    """Return an object straight ahead, of radius 1 m."""
    vehicle = vehicle_at(np.zeros(3), quat_from_euler(0.0, 0.0, 0.0), NO_SIGMA, NO_SIGMA)
    assert vehicle is not None
    position, variance = np.array([[place_m], [0.0], [0.0]]), np.full((3, 1), variance_m2)
    one = np.ones(1)
    estimate = Estimate(position, variance, np.zeros(1), np.zeros((2, 1)), np.zeros((3, 1)), one, 0.1 * one, one)
    return predicted_measurement(position, variance, np.zeros(1), vehicle), estimate


def step_and_variance(share: Floats, away: Floats, variance: float) -> tuple[float, float]:
    """Return how far an object of this variance follows echoes so far away, (k,), its own with these probabilities, and
    its variance then: by an ordinary update with the echo that stands for them."""
    ratio = np.log(share / (1.0 - share.sum()))
    found = hypotheses(np.zeros(len(share), np.intp), np.arange(len(share)), ratio)
    predicted, estimate = one_object(50.0, variance)
    seen = echoes([(float(predicted.rows.range_m[0] + step), 0.0, 1.0) for step in away])
    made = probabilistic(Question(found, np.ones(1, bool), seen, predicted, estimate)).echoes.rows
    gain = variance / (variance + made.sigma_range[0] ** 2)
    return float(gain * (made.range_m - predicted.rows.range_m)[0]), (1.0 - float(gain)) * variance


@given(st.lists(st.tuples(st.floats(0.1, 1.0), st.floats(-3.0, 3.0)), min_size=1, max_size=4), st.floats(0.01, 10.0))
def test_the_echo_that_stands_for_several_does_what_they_do(echo: list[tuple[float, float]], variance: float) -> None:
    """Against the formula of probabilistic data association; where the variance would grow, it stays nearly."""
    share, innovation = (np.array(column) for column in zip(*echo, strict=True))
    share /= share.sum() + 0.09
    step, after = step_and_variance(share, innovation, variance)
    seen, mean = float(share.sum()), float(share @ innovation)
    total = variance + SIGMA_RANGE**2
    gain = variance / total
    lowered = max(seen * total - (float(share @ innovation**2) - mean**2), LEAST_GAIN * total)
    assert after == pytest.approx(variance - gain**2 * lowered)
    assert step == pytest.approx(gain * mean * lowered / (seen * total), abs=1e-9)


def test_the_step_is_theirs_where_innovations_are_not_spread() -> None:
    """One echo, near where it is expected, the object's own with probability 0.8."""
    small, seen, variance = 1e-4, 0.8, 0.3
    step, _ = step_and_variance(np.array([seen]), np.array([small]), variance)
    assert step == pytest.approx(seen * variance / (variance + SIGMA_RANGE**2) * small, rel=1e-4)


def test_a_sure_echo_of_one_object_is_taken_as_it_is() -> None:
    found = hypotheses(np.array([0]), np.array([0]), np.array([40.0]))
    seen = echoes([(50.2, 0.01, 1.4)])
    assignment = probabilistic(Question(found, np.ones(1, bool), seen, *one_object(50.0)))
    np.testing.assert_allclose(assignment.echoes.table, seen.table, rtol=1e-9)
    assert assignment.explained.tolist() == [True]


def test_two_echoes_alike_give_their_middle_with_more_noise() -> None:
    found = hypotheses(np.array([0, 0]), np.array([0, 1]), np.array([10.0, 10.0]))
    seen = echoes([(50.2, 0.0, 1.0), (49.9, 0.0, 1.0)])
    assignment = probabilistic(Question(found, np.ones(1, bool), seen, *one_object(50.0)))
    total = 0.04 + 0.1**2
    lowered = total - 0.15**2
    assert assignment.echoes.rows.range_m[0] == pytest.approx(50.05)
    assert assignment.echoes.rows.sigma_range[0] ** 2 == pytest.approx(0.01 + total * (total / lowered - 1.0), rel=1e-3)
    assert assignment.pairs.llr[0] == pytest.approx(10.0 + math.log(2.0), abs=1e-3)


@pytest.mark.parametrize(("rival", "cut"), [(2.0, True), (-2.0, True), (-8.0, False)])
def test_what_may_be_cut_off_counts_as_cut_off(rival: float, cut: bool) -> None:
    """The second echo is cut off; `rival`: its log-likelihood ratio above that of the first."""
    found = hypotheses(np.array([0, 0]), np.array([0, 1]), np.array([10.0, 10.0 + rival]))
    seen = echoes([(50.05, 0.0, 1.0), (49.9, 0.0, 1.0)])
    seen.rows.cut[:] = 0.0, 1.0
    assignment = probabilistic(Question(found, np.ones(1, bool), seen, *one_object(50.0)))
    assert (assignment.echoes.rows.cut[0] > 0.0) == cut


@given(
    st.lists(st.tuples(st.floats(-0.5, 0.5), st.floats(0.01, 0.2), st.floats(5.0, 10.0)), min_size=1, max_size=4),
    st.booleans(),
)
def test_heights_are_those_that_any_likely_plane_leaves_open(
    planes: list[tuple[float, float, float]], reported: bool
) -> None:
    """Against the hull of the openings of all echoes but those of a tenth of the best one's probability."""
    level, half, ratio = (np.array(column) for column in zip(*planes, strict=True))
    half = half if reported else np.zeros(len(planes))
    found = hypotheses(np.zeros(len(planes), np.intp), np.arange(len(planes)), ratio)
    seen = echoes([(50.0, 0.0, 1.0)] * len(planes))
    seen.rows.elevation[:], seen.rows.half_vertical[:] = level, half
    made = probabilistic(Question(found, np.ones(1, bool), seen, *one_object(50.0))).echoes.rows
    best = int(ratio.argmax())
    likely = ratio - ratio[best] >= math.log(0.1)
    assume(np.abs(ratio - ratio[best] - math.log(0.1)).min() > 1e-6)
    lowest, highest = (level - half)[likely].min(), (level + half)[likely].max()
    expected = (0.5 * (lowest + highest), 0.5 * (highest - lowest)) if reported else (level[best], 0.0)
    assert (made.elevation[0], made.half_vertical[0]) == pytest.approx(expected, abs=1e-9)


def test_unconfirmed_objects_take_one_echo_each_from_what_is_left() -> None:
    found = hypotheses(np.array([0, 1, 1, 2]), np.array([0, 0, 1, 1]), np.array([9.0, 12.0, 3.0, 5.0]))
    position = np.zeros((3, 3))
    position[0] = 50.0
    one = np.ones(3)
    vehicle = vehicle_at(np.zeros(3), quat_from_euler(0.0, 0.0, 0.0), NO_SIGMA, NO_SIGMA)
    assert vehicle is not None
    estimate = Estimate(position, 0.04 * np.ones((3, 3)), 0.0 * one, np.zeros((2, 3)), np.zeros((3, 3)), one, one, one)
    predicted = predicted_measurement(position, estimate.variance, estimate.covariance_ne, vehicle)
    seen = echoes([(50.0, 0.0, 1.0), (50.1, 0.0, 1.0)])
    assignment = probabilistic(Question(found, np.array([True, False, False]), seen, predicted, estimate))
    assert dict(zip(assignment.pairs.objects.tolist(), assignment.pairs.echoes.tolist(), strict=True)) == {0: 0, 2: 1}
