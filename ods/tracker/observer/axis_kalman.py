"""The paper's Kalman filter of one axis, position and velocity, on its own: the theory is in `axis_kalman.h`."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native


class AxisState(NamedTuple):
    """Position and velocity along one axis, and the factors of their covariance."""

    position: float
    velocity: float
    variance: float
    """Of the position;"""
    slope: float
    """its covariance with the velocity, over that;"""
    residual: float
    """variance that would be left of the velocity if the position were known."""


def predict(state: AxisState, dt: float, noise: float) -> AxisState:
    """Time update over `dt` >= 0 seconds. `noise`: spectral density of the acceleration, m^2/s^3."""
    states = _column(state)
    native.axis_predict(states, dt, noise)
    return AxisState(*states[:, 0].tolist())


def update(state: AxisState, measured: float, noise_variance: float) -> AxisState:
    """Measurement update of position with `noise_variance` > 0; slope and residual stay."""
    states = _column(state)
    native.axis_update(states, np.array([measured]), np.array([noise_variance]))
    return AxisState(*states[:, 0].tolist())


def _column(state: AxisState) -> Floats:
    return np.array(state, float)[:, None]


def update_constant(value: float, variance: float, measured: float, noise_variance: float) -> tuple[float, float]:
    """Measurement update of a 1-state filter (a radius, a coordinate of a static object): value and variance."""
    updated = update(AxisState(value, 0.0, variance, 0.0, 0.0), measured, noise_variance)
    return updated.position, updated.variance


def velocity_variance(variance: float, slope: float, residual: float) -> float:
    """Return var(velocity) of the factored covariance."""
    return residual + slope**2 * variance
