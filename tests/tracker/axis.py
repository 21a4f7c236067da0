"""The closed-form filter of one axis (`axis_kalman.h`) by itself: north of the observer `independent`."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled import native
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.observer.horizontal import STATE, Heights, Learned
from ods.tracker.observer.kalman.independent import CrossCovariances, IndependentState
from tests.tracker.fixes import fixes_of

ROWS = [IndependentState._fields.index(name) for name in ("position", "velocity", "variance", "slope", "residual")]


class AxisState(NamedTuple):
    """Position and velocity of an axis, and the factors of their covariance: (n,) each."""

    position: Floats
    velocity: Floats
    variance: Floats
    slope: Floats
    residual: Floats

    def velocity_variance(self) -> Floats:
        """Return (n,)."""
        return np.asarray(self.residual + self.slope**2 * self.variance)


def axis(position: float, velocity: float, variance: float, slope: float, residual: float) -> AxisState:
    """Return the state of one object."""
    return AxisState(*(np.array([number]) for number in (position, velocity, variance, slope, residual)))


def predict(state: AxisState, dt: float, noise: float) -> AxisState:
    """Carry the states on over `dt` seconds; `noise`: spectral density of the acceleration, m^2/s^3."""
    tables = _tables(state)
    native.independent_predict(tables, dt, (noise, 0.0, 0.0))
    return AxisState(*tables[0][ROWS, 0])


def update(state: AxisState, measured: Floats, noise_variance: Floats) -> AxisState:
    """Correct the states by a measured position each, (n,), with its variance, (n,)."""
    tables, n = _tables(state), len(state.position)
    reported: PositionMeasurement = fixes_of(
        np.array([measured, measured]), np.array([noise_variance, noise_variance, np.zeros(n)])
    )
    heights, learned = np.zeros((len(Heights._fields), 2, n)), np.empty((len(Learned._fields), 2, n))
    native.independent_update(tables, np.arange(n), reported, heights, learned)
    return AxisState(*tables[0][ROWS, 0])


def _tables(state: AxisState) -> tuple[Floats, Floats, Floats]:
    """Return those of the observer: north and east alike."""
    n = len(state.position)
    filters = np.ones((len(IndependentState._fields), 2, n))
    filters[ROWS] = np.stack(state)[:, None]
    return filters, np.zeros((len(CrossCovariances._fields), n)), np.zeros((2, UNSEEN, STATE, n))
