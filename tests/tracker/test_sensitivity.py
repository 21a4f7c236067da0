"""What is learned of the height's square, filter and bias apart, against one large textbook filter of both; a climb."""

from collections.abc import Iterator

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.compiled import native
from ods.tracker.measurement.model import BEND, CLIMB, HEIGHT, UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTables
from ods.tracker.observer.horizontal import Heights, NewPlaces
from ods.tracker.observer.kalman.imm import InteractingModels, Model
from ods.tracker.observer.motion_hypotheses import CommonState
from ods.tracker.settings import MotionSettings

DT, NOISE, SQUARE_VARIANCE = 0.5, 0.02, 400.0
NO_HEIGHT = 1e-12
ONE = np.array([0])
Fix = tuple[Floats, Floats, Floats]
"""Place (2,), noise (2, 2), change of the place (2,) per m^2."""


class LargeFilter:
    """North, east, their velocities and the height's square in full matrices."""

    def __init__(self, first: Fix, velocity_variance: float) -> None:
        place, noise, bend = first
        self.x = np.array([*place, 0.0, 0.0, 0.0])
        by_square = np.array([*bend, 0.0, 0.0, 1.0])
        self.p: Floats = SQUARE_VARIANCE * np.outer(by_square, by_square)
        self.p[:2, :2] += noise
        self.p[2:4, 2:4] += velocity_variance * np.eye(2)

    def predict(self, noise: float) -> None:
        f, one = np.eye(5), np.eye(2)
        f[0, 2] = f[1, 3] = DT
        self.x, self.p = f @ self.x, f @ self.p @ f.T
        axis = noise * np.array([[DT**3 / 3.0, DT**2 / 2.0], [DT**2 / 2.0, DT]])
        self.p[:4, :4] += np.kron(axis, one)

    def update(self, fix: Fix) -> float:
        """Return the log of the density of the fix, times 2 pi."""
        place, noise, bend = fix
        h = np.zeros((2, 5))
        h[:, :2], h[:, 4] = np.eye(2), -bend
        innovation, s = place - h @ self.x, h @ self.p @ h.T + noise
        gain = np.linalg.solve(s, h @ self.p).T
        self.x = self.x + gain @ innovation
        keep = np.eye(5) - gain @ h
        self.p = keep @ self.p @ keep.T + gain @ noise @ gain.T
        return float(-0.5 * (innovation @ np.linalg.solve(s, innovation) + np.log(np.linalg.det(s))))


def fixes(count: int) -> Iterator[Fix]:
    """Yield fixes of which the square changes the place ever more, as when an object comes nearer."""
    rng = np.random.default_rng(3)
    for k in range(count):
        root = 0.3 * rng.standard_normal((2, 2))
        yield rng.standard_normal(2), root @ root.T + 0.01 * np.eye(2), 0.01 * (1.0 + k) * rng.standard_normal(2)


def measurement(fix: Fix) -> PositionMeasurement:
    place, noise, bend = fix
    sensitivity = np.zeros((UNSEEN, 2, 1))
    sensitivity[BEND, :, 0] = bend
    zero, one = np.zeros(1), np.ones(1)
    spread = noise[0, 0] * one, noise[1, 1] * one, noise[0, 1] * one
    level = zero, np.zeros((2, 1)), sensitivity, np.zeros(2)
    return PositionMeasurement(np.array([[*place, 0.0]]).T, *spread, one, one, one, *level)


def test_square_of_the_height_is_learned_as_by_one_large_filter() -> None:
    motion = MotionSettings(acceleration_noise=NOISE, static_noise=0.0)
    filters = InteractingModels(motion, [Model(NOISE, 1.0)])
    first, *others = fixes(12)
    reported = measurement(first)
    noise = np.stack([reported.variance_north, reported.variance_east])
    TrackTables(filters.tables()).extend(1)
    filters.start(NewPlaces(reported.position[:2], noise, reported.covariance_ne, reported.sensitivity))
    large = LargeFilter(first, 0.0), LargeFilter(first, motion.velocity_sigma**2)
    square, variance, zero = np.zeros((2, 1)), np.full((2, 1), SQUARE_VARIANCE), np.zeros((2, 1))
    for fix in others:
        filters.predict(DT)
        heights = Named(Heights, np.array([zero, np.full((2, 1), NO_HEIGHT), square, variance, zero]))
        learned = filters.update(ONE, measurement(fix), np.zeros(1), heights).rows
        square, variance = learned.square, learned.square_variance
        large[0].predict(0.0)
        large[1].predict(NOISE)
        density = [one.update(fix) for one in large]
        assert np.subtract(*learned.log_likelihood) == pytest.approx(density[0] - density[1], abs=1e-6)
        for g, one in enumerate(large):
            assert (square[g, 0], variance[g, 0]) == pytest.approx((one.x[4], one.p[4, 4]), rel=1e-6)
            by_square = filters.state().unseen[g, BEND, :2, 0]
            place = filters.state().position[g, :, 0] + by_square * square[g, 0]
            np.testing.assert_allclose(place, one.x[:2], rtol=1e-6, atol=1e-9)
            own = np.diag(filters.state().variance[g, :, 0]) + filters.state().covariance_ne[g, 0] * np.eye(2)[::-1]
            whole = own + variance[g, 0] * np.outer(by_square, by_square)
            np.testing.assert_allclose(whole, one.p[:2, :2], rtol=1e-6, atol=1e-9)


def test_what_a_climb_does_to_the_estimate_is_the_derivative_by_it() -> None:
    """Two objects that end at one height and place, one of which climbed: by how much are their estimates apart?"""
    rng = np.random.default_rng(5)
    climb, zero = MotionSettings().vertical_velocity_sigma, np.zeros((2, 1))
    level, climbing = (InteractingModels(MotionSettings(), [Model(NOISE, 1.0)]) for _ in range(2))
    count = 10
    for k in range(count):
        reported = measurement((np.zeros(2), 0.1 * np.eye(2), np.zeros(2)))
        reported.sensitivity[HEIGHT, :, 0] = slope = rng.standard_normal(2)
        moved = reported._replace(position=reported.position.copy())
        moved.position[:2, 0] -= slope * climb * DT * (k + 1 - count)
        for filters, fix in ((level, reported), (climbing, moved)):
            if k == 0:
                noise = np.stack([fix.variance_north, fix.variance_east])
                TrackTables(filters.tables()).extend(1)
                filters.start(NewPlaces(fix.position[:2], noise, fix.covariance_ne, fix.sensitivity))
                continue
            filters.predict(DT)
            filters.update(ONE, fix, np.zeros(1), Named(Heights, np.array([zero, zero + NO_HEIGHT, zero, zero, zero])))
    apart = climbing.state().position[1, :, 0] - level.state().position[1, :, 0]
    np.testing.assert_allclose(-level.state().unseen[1, CLIMB, :2, 0], apart, rtol=1e-6, atol=1e-9)
    assert np.hypot(*apart) > 0.01
    assert not level.state().unseen[0, CLIMB].any()


def test_square_is_one_that_the_height_can_have() -> None:
    """Even between -h and h: variance h^2 / 3, largest square h^2, mean fourth power h^4 / 5."""
    half = 2.5
    common, zero = np.zeros((len(CommonState._fields), 3)), np.zeros((2, 3))
    common[CommonState._fields.index("radius_variance")] = 1.0
    square, variance = [100.0, -1.0, 1.0], [1e9, 0.1, 0.2]
    learned = np.array([zero, zero, zero + half**2 / 3.0, [square] * 2, [variance] * 2])
    seen = np.ones(3), np.ones(3), np.zeros(2)
    limits = 0.0, (0.0, -5.0, 8.0)
    native.common_update(
        common, np.arange(3), seen, np.zeros((5, 2, 3)), learned, np.zeros(3), limits, np.empty(3, int)
    )
    found = CommonState(*common)
    for squares, variances in (
        (found.rest_square, found.rest_square_variance),
        (found.square, found.square_variance),
    ):
        np.testing.assert_allclose(squares, [half**2, 0.0, 1.0])
        np.testing.assert_allclose(variances, [half**4 / 5.0, 0.1, 0.2])
