"""The closed-form Kalman filters against full matrices in extended precision, and against closed forms."""

from dataclasses import dataclass

import numpy as np
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from benchmarks.covariance_forms import ACCELERATION_NOISE, Factors
from ods.compiled import native
from ods.tracker.observer import axis_kalman
from ods.tracker.observer.axis_kalman import AxisState

Long = NDArray[np.longdouble]


@dataclass
class Axis:
    """One axis for the filter under test."""

    position: float = 0.0
    variance: float = 1.0
    residual: float = 1.0
    velocity: float = 0.0
    slope: float = 0.0

    def predict(self, dt: float, noise: float) -> None:
        self._take(axis_kalman.predict(self._state(), dt, noise))

    def update(self, measured: float, noise_variance: float) -> None:
        self._take(axis_kalman.update(self._state(), measured, noise_variance))

    def _state(self) -> AxisState:
        return AxisState(self.position, self.velocity, self.variance, self.slope, self.residual)

    def _take(self, state: AxisState) -> None:
        self.position, self.velocity, self.variance, self.slope, self.residual = state

    def covariance(self) -> tuple[float, float, float]:
        """Return var(position), cov, var(velocity)."""
        return (
            self.variance,
            self.slope * self.variance,
            axis_kalman.velocity_variance(self.variance, self.slope, self.residual),
        )


class MatrixFilter:
    """The textbook filter: full 2 x 2 matrices, extended precision, no trick."""

    def __init__(self, position: float, variance: float, velocity_variance: float) -> None:
        self.x: Long = np.array([position, 0.0], np.longdouble)
        self.p: Long = np.diag(np.array([variance, velocity_variance], np.longdouble))

    def predict(self, dt: float, noise: float) -> None:
        h = np.longdouble(dt)
        f = np.array([[1, h], [0, 1]], np.longdouble)
        q = np.longdouble(noise) * np.array([[h**3 / 3, h**2 / 2], [h**2 / 2, h]], np.longdouble)
        self.x = f @ self.x
        self.p = f @ self.p @ f.T + q

    def update(self, measured: float, noise_variance: float) -> None:
        gain = self.p[:, 0] / (self.p[0, 0] + np.longdouble(noise_variance))
        self.x = self.x + gain * (np.longdouble(measured) - self.x[0])
        keep = np.eye(2, dtype=np.longdouble) - np.outer(gain, np.array([1, 0], np.longdouble))
        noise: Long = np.outer(gain, gain) * np.longdouble(noise_variance)
        self.p = keep @ self.p @ keep.T + noise


steps = st.lists(
    st.tuples(st.floats(0.0, 30.0), st.one_of(st.none(), st.tuples(st.floats(-50.0, 50.0), st.floats(1e-4, 1e3)))),
    min_size=1,
    max_size=40,
)


@settings(max_examples=150)
@given(steps, st.floats(0.0, 10.0))
def test_the_closed_form_equals_the_matrix_form(
    sequence: list[tuple[float, tuple[float, float] | None]], noise: float
) -> None:
    mine, textbook = Axis(3.0, 2.0, 0.5), MatrixFilter(3.0, 2.0, 0.5)
    for dt, measurement in sequence:
        mine.predict(dt, noise)
        textbook.predict(dt, noise)
        if measurement:
            mine.update(*measurement)
            textbook.update(*measurement)
    pp, pv, vv = mine.covariance()
    scale = float(np.sqrt(textbook.p[0, 0])), float(np.sqrt(textbook.p[1, 1]))
    np.testing.assert_allclose(pp, float(textbook.p[0, 0]), rtol=1e-9)
    np.testing.assert_allclose(vv, float(textbook.p[1, 1]), rtol=1e-9)
    np.testing.assert_allclose(pv, float(textbook.p[0, 1]), rtol=1e-9, atol=1e-9 * scale[0] * scale[1])
    np.testing.assert_allclose(mine.position, float(textbook.x[0]), rtol=1e-9, atol=1e-7)
    np.testing.assert_allclose(mine.velocity, float(textbook.x[1]), rtol=1e-9, atol=1e-7)


def test_without_process_noise_the_result_is_the_fitted_line() -> None:
    t = np.cumsum(np.array([0.3, 0.1, 0.9, 0.0, 2.0, 0.4]))
    z = np.array([1.2, 1.0, 2.9, 2.6, 5.1, 5.2])
    line = Axis(0.0, variance=1e12, residual=1e12)
    now = 0.0
    for when, value in zip(t.tolist(), z.tolist(), strict=True):
        line.predict(when - now, 0.0)
        line.update(value, 0.25)
        now = when
    design = np.column_stack([np.ones_like(t), t - now])
    (place, speed), *_ = np.linalg.lstsq(design, z, rcond=None)
    covariance = 0.25 * np.linalg.inv(design.T @ design)
    pp, pv, vv = line.covariance()
    np.testing.assert_allclose([line.position, line.velocity], [place, speed], rtol=1e-6)
    np.testing.assert_allclose([pp, pv, vv], covariance[[0, 0, 1], [0, 1, 1]], rtol=1e-6)


def test_a_constant_is_averaged() -> None:
    value, variance = 5.0, 4.0
    for _ in range(9):
        value, variance = axis_kalman.update_constant(value, variance, 7.0, 4.0)
    np.testing.assert_allclose([value, variance], [(5.0 + 9 * 7.0) / 10, 0.4])


def test_no_time_changes_nothing() -> None:
    line = Axis(1.0, 2.0, 3.0)
    line.predict(0.7, 0.1)
    before = dict(vars(line))
    line.predict(0.0, 0.1)
    assert vars(line) == before


@given(st.floats(1e-9, 1e5), st.floats(0.0, 1.0), st.floats(1e-6, 1e3))
def test_two_steps_equal_a_long_one(dt: float, share: float, noise: float) -> None:
    once, twice = Axis(1.0, 2.0, 3.0), Axis(1.0, 2.0, 3.0)
    once.predict(dt, noise)
    twice.predict(dt * share, noise)
    twice.predict(dt - dt * share, noise)
    for a, b in zip(once.covariance(), twice.covariance(), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9)


def test_it_stays_positive_definite_whatever_the_noise() -> None:
    """A million updates of all kinds: intervals from 1e-9 to 1e5 s, noise from 1e-12 to 1e12 m^2, places at 1e6 m."""
    rng = np.random.default_rng(1)
    lines = np.repeat(np.array([[1e6], [0.0], [1e-12], [0.0], [1e6]]), 1000, axis=1)
    for _ in range(1000):
        noise_variance = 10.0 ** rng.uniform(-12, 12, 1000)
        measured = 1e6 + rng.normal(0.0, 1.0, 1000)
        dt, noise = float(10.0 ** rng.uniform(-9, 5)), float(10.0 ** rng.uniform(-6, 2))
        native.axis_predict(lines, dt, noise)
        native.axis_update(lines, measured, noise_variance)
        assert (lines[[2, 4]] > 0.0).all()
    assert np.isfinite(lines).all()


def test_the_forms_compared_are_those_of_the_tracker() -> None:
    """What the benchmark of forms measures in either precision is what the tracker computes."""
    forms, lines = Factors(3, np.float64), np.repeat(np.array([[0.0], [0.0], [1.0], [0.0], [1.0]]), 3, axis=1)
    for k in range(5):
        noise = np.array([0.01, 1.0, 100.0]) * (1.0 + k)
        forms.predict(0.3 + k)
        forms.update(noise)
        native.axis_predict(lines, 0.3 + k, ACCELERATION_NOISE)
        native.axis_update(lines, np.zeros(3), noise)
    np.testing.assert_allclose(lines[2:], [forms.variance, forms.slope, forms.residual], rtol=1e-12)


def test_everything_known_exactly_stays_so() -> None:
    line = Axis(1.0, 0.0, 0.0)
    line.predict(5.0, 0.0)
    line.update(9.0, 1.0)
    assert line.position == 1.0
    assert np.isfinite(line.covariance()).all()
