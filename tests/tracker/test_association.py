"""Gate and evidence against the plain formula, assignment against all permutations, parts of large objects."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.stats import multivariate_normal, norm

from ods.base.arrays import Floats, Indices
from ods.base.frames.geometry import quat_from_euler
from ods.messages import Sector
from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.gnn import best_pairs
from ods.tracker.association.hypotheses.clutter import Clutter, ClutterDensity
from ods.tracker.association.hypotheses.gating import Detectability, Hypotheses, hypotheses
from ods.tracker.association.match import shown
from ods.tracker.measurement.coverage.field_of_view import FieldOfView
from ods.tracker.measurement.scan import vehicle_at
from ods.tracker.observer.belief import Belief, Estimate
from ods.tracker.settings import EchoSettings
from tests.tracker.samples import NO_SIGMA, echoes, predicted_measurement

SETTINGS = EchoSettings()
VEHICLE = vehicle_at(np.zeros(3), quat_from_euler(0.0, 0.0, 0.0), NO_SIGMA, NO_SIGMA)


def belief(positions: Floats, variances: Floats, weights: Floats, radius: Floats) -> Belief:
    """(h, n, 2) positions and variances, (h, n) weights."""
    shape = len(weights), 3, len(radius)
    position, variance = np.zeros(shape), np.full(shape, 1e-9)
    position[:, :2], variance[:, :2] = np.swapaxes(positions, 1, 2), np.swapaxes(variances, 1, 2)
    static = weights[0]
    by_height, shared = np.zeros_like(position[:, :2]), np.zeros_like(position)
    return Belief(
        weights,
        position,
        variance,
        np.zeros(weights.shape),
        by_height,
        shared,
        radius,
        np.full(len(radius), 0.04),
        static,
        np.zeros(len(radius)),
    )


@pytest.mark.parametrize("radius_m", [0.3, 5.0, 12.0, 20.0])
def test_the_density_of_false_alarms_radii_has_an_integral_of_one(radius_m: float) -> None:
    """All that was larger than 7.5 m counted as if it were within 0.5 m: no wall that fills the fan was confirmed."""
    clutter, sector = Clutter(1.0), Sector(0.5, 100.0, -0.7, 0.7, 0.17)
    for _ in range(100):
        clutter.count(echoes([(30.0, 0.1, radius_m)]), sector)
    step_m = 0.05
    radii = np.arange(0.5 * step_m, 40.0, step_m)
    density = clutter.density(echoes([(30.0, 0.1, float(radius)) for radius in radii]), sector).radius
    within = radii < 25.0
    assert step_m * float(density[within].sum()) == pytest.approx(1.0, abs=1e-6)


def test_hypotheses_are_those_of_the_plain_formula() -> None:
    rng = np.random.default_rng(4)
    n, m = 30, 40
    azimuth = rng.uniform(-0.7, 0.7, (1, n, 1))
    direction = np.concatenate([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    places = rng.uniform(20.0, 60.0, (1, n, 1)) * direction + rng.normal(0.0, 1.0, (2, n, 2))
    believed = belief(places, rng.uniform(0.01, 2.0, (2, n, 2)), np.array([[0.3] * n, [0.7] * n]), rng.uniform(1, 2, n))
    seen = echoes(
        [
            (float(r), float(b), float(a))
            for r, b, a in zip(rng.uniform(15, 65, m), rng.uniform(-0.8, 0.8, m), rng.uniform(0.5, 2.5, m), strict=True)
        ]
    )
    clutter = ClutterDensity(rng.uniform(1e-4, 1e-2, m), np.ones(m), rng.uniform(0.1, 1.0, m))
    assert VEHICLE is not None
    predicted = predicted_measurement(believed.position, believed.variance, believed.covariance_ne, VEHICLE)
    chance = Detectability(np.ones(n), SETTINGS.detection_probability)
    found = hypotheses(predicted, believed, seen, clutter, chance, SETTINGS.gate_sigmas)

    expected = {}
    for i, j in itertools.product(range(n), range(m)):
        distances, density = [], 0.0
        for h in range(2):
            north, east = believed.position[h, :2, i]
            horizontal, bearing = math.hypot(north, east), math.atan2(east, north)
            turn = np.array([[math.cos(bearing), math.sin(bearing)], [-math.sin(bearing), math.cos(bearing)]])
            s = turn @ np.diag(believed.variance[h, :2, i]) @ turn.T
            away = math.hypot(horizontal, math.sqrt(s[1, 1]))  # what is uncertain aside makes it farther
            s += np.diag([seen.rows.sigma_range[j] ** 2, (horizontal * seen.rows.sigma_bearing[j]) ** 2])
            innovation = np.array([seen.rows.range_m[j] - away, (seen.rows.bearing[j] - bearing) * horizontal])
            distances.append(innovation @ np.linalg.inv(s) @ innovation)
            density += believed.weight[h, i] * multivariate_normal.pdf(innovation, cov=s)
        if min(distances) <= 16.0:
            radius = norm.logpdf(seen.rows.radius[j], believed.radius[i], math.sqrt(0.04 + 0.09)) - math.log(
                clutter.radius[j]
            )
            expected[i, j] = math.log(0.9 * density / clutter.per_m2[j]) + max(radius, -4.5)
    assert len(expected) > 10
    got = dict(zip(zip(found.objects.tolist(), found.echoes.tolist(), strict=True), found.llr, strict=True))
    assert got.keys() == expected.keys()
    for pair, value in expected.items():
        assert got[pair] == pytest.approx(value, abs=1e-6)


def pairs_of(matrix: Floats) -> Hypotheses:
    """Return pairs whose ratio is given, and their score 1 more."""
    rows, columns = np.nonzero(np.isfinite(matrix))
    return Hypotheses(rows, columns, matrix[rows, columns], matrix[rows, columns] + 1.0)


def best_sum(matrix: Floats, miss: float) -> float:
    """Try everything: each object gets one echo or none."""
    worth = np.where(np.isfinite(matrix), matrix - miss, -np.inf)
    n, m = worth.shape
    best = 0.0
    for choice in itertools.product(range(-1, m), repeat=n):
        used = [j for j in choice if j >= 0]
        if len(used) == len(set(used)):
            best = max(best, sum(worth[i, j] for i, j in enumerate(choice) if j >= 0))
    return float(best)


@settings(max_examples=60)
@given(st.integers(1, 4), st.integers(1, 5), st.integers(0, 10_000))
def test_the_assignment_is_the_best_there_is(n: int, m: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    matrix = rng.normal(1.0, 3.0, (n, m))
    matrix[rng.random((n, m)) < 0.4] = np.nan
    found = pairs_of(matrix)
    pairs = best_pairs(found, np.zeros(n, bool), m)
    assert len(set(pairs.objects)) == len(pairs.objects)
    assert len(set(pairs.echoes)) == len(pairs.echoes)
    assert pairs.score.sum() == pytest.approx(best_sum(matrix, -1.0))


def test_confirmed_objects_choose_first() -> None:
    matrix = np.array([[9.0, np.nan], [1.0, 0.5]])
    found = pairs_of(matrix)
    only = best_pairs(found, np.array([False, True]), 2)
    assert dict(zip(only.objects.tolist(), only.echoes.tolist(), strict=True)) == {1: 0}


def test_nothing_to_associate() -> None:
    nothing: Indices = np.zeros(0, np.intp)
    none = Hypotheses(nothing, nothing, np.zeros(0), np.zeros(0))
    assert len(best_pairs(none, np.zeros(0, bool), 0).objects) == 0


def test_an_echo_of_a_silent_object_needs_more_proof() -> None:
    """Two objects fit an echo alike; the one that has been silent, seen with probability 0.01, stays without."""
    assert VEHICLE is not None
    believed = belief(np.array([[[50.0, 0.0]] * 2]), np.ones((1, 2, 2)), np.ones((1, 2)), np.ones(2))
    predicted = predicted_measurement(believed.position, believed.variance, believed.covariance_ne, VEHICLE)
    clutter, chance = ClutterDensity(*np.full((3, 1), 1e-3)), Detectability(np.array([0.01, 1.0]), 0.9)
    found = hypotheses(predicted, believed, echoes([(50.0, 0.0, 1.0)]), clutter, chance, SETTINGS.gate_sigmas)
    assert found.llr[0] == found.llr[1]
    np.testing.assert_allclose(found.score - found.llr, [math.log(0.01 / (1 - 0.009)), -math.log(0.1)])
    assert best_pairs(found, np.ones(2, bool), 1).objects.tolist() == [1]


def test_parts_are_found_inside_the_circle_only() -> None:
    """An object of 6 m radius at 50 m: echoes 4 m right and 5 m beyond are its parts, one 7 m to the left is not."""
    assert VEHICLE is not None
    seen = echoes([(50.0, 4.0 / 50.0, 2.0), (55.0, 0.0, 2.0), (50.0, -7.0 / 50.0, 2.0)])
    position, one, none = np.array([[50.0], [0.0], [0.0]]), np.ones(1), np.zeros(1)
    estimate = Estimate(position, np.ones((3, 1)), none, np.zeros((2, 1)), np.zeros((3, 1)), 6.0 * one, one, one)
    predicted = predicted_measurement(position, np.ones((3, 1)), none, VEHICLE)
    yes = np.ones(1, bool)
    nobody = Hypotheses(np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0), np.zeros(0))
    asked = Question(nobody, yes, seen, predicted, estimate)
    answer = Assignment(nobody, seen.take(nobody.echoes), np.zeros(3, bool))
    by_chance = np.array([math.exp(-1.0), math.exp(-3.0), 0.5])
    clutter = ClutterDensity(by_chance / (math.pi * 6.0**2), np.ones(3), np.ones(3))
    view = FieldOfView(yes, one, ~yes, ~yes, one)
    together = shown(asked, answer, view, clutter, Detectability(one, 0.9))
    assert together.unexplained.tolist() == [2]
    assert together.objects.tolist() == [0]
    assert together.evidence.rows.llr.tolist() == [pytest.approx(3.0)]
    assert together.echoes.rows.range_m.tolist() == [52.5]
    assert together.echoes.rows.bearing[0] == pytest.approx(0.04)
