"""The paper's Kalman filters in closed form: position and velocity along one axis, event driven [SSIE eq. 2].

State of an axis: position and velocity; its covariance P = L D L' is kept in factors, L = [[1, 0], [slope, 1]] and
D = diag(variance, residual):

    variance = var(position)
    slope    = cov(position, velocity) / var(position)
    residual = var(velocity) that would be left if the position were known

In this form a measurement of position changes nothing but `variance` (slope and residual drop out of the update), and
the time update is a sum of positive terms only: P stays symmetric and positive definite whatever the noise ratios and
intervals. Arrays hold all objects at once and may have any one shape.
Factored filters: G. J. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977.
"""

from ods.geometry import Array

TINY = 1e-300
"""Keeps 0 / 0 out of an axis whose position and velocity are both known exactly."""


def predict(
    position: Array, velocity: Array, variance: Array, slope: Array, residual: Array, dt: float, noise: float
) -> None:
    """Time update over `dt` >= 0 seconds, in place. `noise`: spectral density of the acceleration, m^2/s^3.

    Process noise of white acceleration: Q = noise * [[dt^3/3, dt^2/2], [dt^2/2, dt]]; two steps equal one long one.
    """
    if dt == 0.0:
        return
    turn = slope * dt
    new_variance = variance * (1.0 + turn) ** 2 + residual * dt**2 + (noise * dt**3 / 3.0 + TINY)
    covariance = variance * slope * (1.0 + turn) + residual * dt + noise * dt**2 / 2.0
    # det(A + Q) = det A + det Q + tr(adj(Q) A), the last written as a sum of squares.
    mixed = variance * ((1.0 + turn / 2.0) ** 2 + turn**2 / 12.0) + residual * (dt**2 / 3.0)
    determinant = variance * residual + (noise * dt) * mixed + noise**2 * dt**4 / 12.0
    position += velocity * dt
    slope[...] = covariance / new_variance
    residual[...] = determinant / new_variance
    variance[...] = new_variance


def update(
    position: Array, velocity: Array, variance: Array, slope: Array, innovation: Array, noise_variance: Array
) -> None:
    """Measurement update of position, in place. `innovation`: measured minus predicted; `noise_variance` > 0."""
    gain = variance / (variance + noise_variance)
    step = gain * innovation
    position += step
    velocity += slope * step
    variance[...] = gain * noise_variance


def update_constant(value: Array, variance: Array, innovation: Array, noise_variance: Array) -> None:
    """Measurement update of a 1-state filter (a radius, a coordinate of a static object), in place."""
    gain = variance / (variance + noise_variance)
    value += gain * innovation
    variance[...] = gain * noise_variance


def velocity_variance(variance: Array, slope: Array, residual: Array) -> Array:
    """Return var(velocity) of the factored covariance."""
    return residual + slope**2 * variance
