"""The closed-form Kalman filters against full matrices in extended precision, and against closed forms."""

import numpy as np
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from tests.tracker import axis

Long = NDArray[np.longdouble]


class Axis:
    """One object of the filter under test."""

    def __init__(self, position: float = 0.0, variance: float = 1.0, residual: float = 1.0) -> None:
        self.state = axis.axis(position, 0.0, variance, 0.0, residual)

    def predict(self, dt: float, noise: float) -> None:
        self.state = axis.predict(self.state, dt, noise)

    def update(self, measured: float, noise_variance: float) -> None:
        self.state = axis.update(self.state, np.array([measured]), np.array([noise_variance]))

    def place(self) -> tuple[float, float]:
        """Return position and velocity."""
        return float(self.state.position[0]), float(self.state.velocity[0])

    def covariance(self) -> tuple[float, float, float]:
        """Return var(position), cov, var(velocity)."""
        s = self.state
        return float(s.variance[0]), float((s.slope * s.variance)[0]), float(s.velocity_variance()[0])


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
    np.testing.assert_allclose(mine.place(), textbook.x.astype(float), rtol=1e-9, atol=1e-7)


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
    np.testing.assert_allclose(line.place(), [place, speed], rtol=1e-6)
    np.testing.assert_allclose([pp, pv, vv], covariance[[0, 0, 1], [0, 1, 1]], rtol=1e-6)


def test_a_constant_is_averaged() -> None:
    constant = Axis(5.0, 4.0, residual=0.0)
    for _ in range(9):
        constant.update(7.0, 4.0)
    np.testing.assert_allclose([constant.place()[0], constant.covariance()[0]], [(5.0 + 9 * 7.0) / 10, 0.4])


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
    lines = axis.AxisState(*np.repeat(np.array([[1e6], [0.0], [1e-12], [0.0], [1e6]]), 1000, axis=1))
    for _ in range(1000):
        noise_variance = 10.0 ** rng.uniform(-12, 12, 1000)
        measured = 1e6 + rng.normal(0.0, 1.0, 1000)
        dt, noise = float(10.0 ** rng.uniform(-9, 5)), float(10.0 ** rng.uniform(-6, 2))
        lines = axis.update(axis.predict(lines, dt, noise), measured, noise_variance)
        assert (lines.variance > 0.0).all()
        assert (lines.residual > 0.0).all()
    assert np.isfinite(np.stack(lines)).all()


def test_everything_known_exactly_stays_so() -> None:
    line = Axis(1.0, 0.0, 0.0)
    line.predict(5.0, 0.0)
    line.update(9.0, 1.0)
    assert line.place()[0] == 1.0
    assert np.isfinite(line.covariance()).all()
