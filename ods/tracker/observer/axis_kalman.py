"""The paper's Kalman filters in closed form: position and velocity along one axis, event driven [SSIE eq. 2].

State of an axis: position and velocity; its covariance P = L D L' is kept in factors, L = [[1, 0], [slope, 1]] and
D = diag(variance, residual):

    variance = var(position)
    slope    = cov(position, velocity) / var(position)
    residual = var(velocity) that would be left if the position were known

In this form a measurement of position changes nothing but `variance` (slope and residual drop out of the update), and
the time update is a sum of positive terms only: P stays symmetric and positive definite whatever the noise ratios and
intervals. All functions are of one axis of one object; observers call them in compiled loops over all.
Factored filters: G. J. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977.
"""

from typing import NamedTuple

from ods.compiled.kernel import kernel

TINY = 1e-300
"""Keeps 0 / 0 out of an axis whose position and velocity are both known exactly."""


class AxisState(NamedTuple):
    """Position and velocity along one axis, and the factors of their covariance."""

    position: float
    velocity: float
    variance: float
    slope: float
    residual: float


@kernel
def predict(state: AxisState, dt: float, noise: float) -> AxisState:
    """Time update over `dt` >= 0 seconds. `noise`: spectral density of the acceleration, m^2/s^3.

    Process noise of white acceleration: Q = noise * [[dt^3/3, dt^2/2], [dt^2/2, dt]]; two steps equal one long one.
    """
    if dt == 0.0:
        return state
    variance, slope, residual = state.variance, state.slope, state.residual
    turn = slope * dt
    new_variance = variance * (1.0 + turn) ** 2 + residual * dt**2 + (noise * dt**3 / 3.0 + TINY)
    covariance = variance * slope * (1.0 + turn) + residual * dt + noise * dt**2 / 2.0
    # det(A + Q) = det A + det Q + tr(adj(Q) A), the last written as a sum of squares.
    mixed = variance * ((1.0 + turn / 2.0) ** 2 + turn**2 / 12.0) + residual * (dt**2 / 3.0)
    determinant = variance * residual + (noise * dt) * mixed + noise**2 * dt**4 / 12.0
    position = state.position + state.velocity * dt
    return AxisState(position, state.velocity, new_variance, covariance / new_variance, determinant / new_variance)


@kernel
def update(state: AxisState, measured: float, noise_variance: float) -> AxisState:
    """Measurement update of position with `noise_variance` > 0; slope and residual stay."""
    gain = state.variance / (state.variance + noise_variance)
    step = gain * (measured - state.position)
    position, velocity = state.position + step, state.velocity + state.slope * step
    return AxisState(position, velocity, gain * noise_variance, state.slope, state.residual)


@kernel
def update_constant(value: float, variance: float, measured: float, noise_variance: float) -> tuple[float, float]:
    """Measurement update of a 1-state filter (a radius, a coordinate of a static object): value and variance."""
    gain = variance / (variance + noise_variance)
    return value + gain * (measured - value), gain * noise_variance


@kernel
def velocity_variance(variance: float, slope: float, residual: float) -> float:
    """Return var(velocity) of the factored covariance."""
    return residual + slope**2 * variance
