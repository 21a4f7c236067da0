"""The paper's observer: independent Kalman filters for north and east, in closed form (`axis_kalman`) [SSIE eq. 2]."""

import math
from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled.kernel import kernel
from ods.tracker.measurement.model import PositionMeasurement
from ods.tracker.named import TrackTable
from ods.tracker.observer import axis_kalman
from ods.tracker.observer.axis_kalman import AxisState
from ods.tracker.observer.motion_hypotheses import HorizontalState
from ods.tracker.settings import MotionSettings


class IndependentState(NamedTuple):
    """Filters of n objects: (2, n) each, north and east."""

    place: Floats
    """Position if the object does not move;"""
    position: Floats
    """if it moves;"""
    place_variance: Floats
    variance: Floats
    """of both;"""
    velocity: Floats
    """if it moves, and the other factors of its covariance (see `axis_kalman`):"""
    slope: Floats
    residual: Floats


POSITIONS, VARIANCES = slice(0, 2), slice(2, 4)
"""The fields above for both hypotheses, RESTING and MOVING."""


@kernel
def _rows(table: Floats) -> IndependentState:
    return IndependentState(table[0], table[1], table[2], table[3], table[4], table[5], table[6])


class IndependentAxes:
    """See `ods.tracker.observer.motion_hypotheses.HorizontalFilter`."""

    def __init__(self, settings: MotionSettings) -> None:
        self._settings = settings
        self._table = TrackTable(IndependentState, (len(IndependentState._fields), 2))

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        _predict(self._table.table, dt, self._settings.acceleration_noise, self._settings.static_noise)

    def state(self) -> HorizontalState:
        """Return where objects are; the arrays are views."""
        s, n = self._table.table, len(self._table)
        return HorizontalState(np.ones((1, n)), s[POSITIONS], s[VARIANCES], np.zeros((2, n)))

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""
        return self._table.rows.velocity, _velocity_variance(self._table.table)

    def append(self, position: Floats, north: Floats, east: Floats, covariance_ne: Floats) -> None:
        """Append objects at (2 or more, k) positions, their variances (k,); the covariance is left out."""
        new = self._table.grow(len(north))
        new.place[:] = new.position[:] = position[:2]
        new.place_variance[:] = new.variance[:] = north, east
        new.residual[:] = self._settings.velocity_sigma**2

    def update(self, rows: Indices, measured: PositionMeasurement, since_s: Floats) -> Floats:
        """Take one measurement an object; return (k,) the log of the likelihood if it is static over that if it moves.

        `since_s` is not needed.
        """
        return _update(self._table.table, rows, measured)

    def rest_there(self, rows: Indices) -> None:
        """Start the static hypothesis anew where the moving one is now."""
        s = self._table.rows
        s.place[:, rows], s.place_variance[:, rows] = s.position[:, rows], s.variance[:, rows]

    def set_out(self, rows: Indices) -> None:
        """Start the moving hypothesis anew where the static one is, with unknown velocity."""
        s = self._table.rows
        s.position[:, rows], s.variance[:, rows] = s.place[:, rows], s.place_variance[:, rows]
        s.velocity[:, rows] = s.slope[:, rows] = 0.0
        s.residual[:, rows] = self._settings.velocity_sigma**2

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let the static hypotheses of `heirs` learn where those of `old`, the same objects, were."""
        _join(self._table.table, heirs, old)

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        self._table.keep(mask)

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects."""
        return [self._table]


@kernel
def _predict(table: Floats, dt: float, acceleration_noise: float, static_noise: float) -> None:
    s = _rows(table)
    for axis in range(2):
        for i in range(table.shape[2]):
            moved = axis_kalman.predict(_moving(s, axis, i), dt, acceleration_noise)
            s.position[axis, i], s.variance[axis, i] = moved.position, moved.variance
            s.slope[axis, i], s.residual[axis, i] = moved.slope, moved.residual
            s.place_variance[axis, i] += static_noise * dt


@kernel
def _moving(s: IndependentState, axis: int, i: int) -> AxisState:
    """Return one axis of object i if it moves."""
    return AxisState(
        s.position[axis, i], s.velocity[axis, i], s.variance[axis, i], s.slope[axis, i], s.residual[axis, i]
    )


@kernel
def _velocity_variance(table: Floats) -> Floats:
    s, found = _rows(table), np.empty(table.shape[1:])
    for axis in range(2):
        for i in range(table.shape[2]):
            found[axis, i] = axis_kalman.velocity_variance(s.variance[axis, i], s.slope[axis, i], s.residual[axis, i])
    return found


@kernel
def _update(table: Floats, rows: Indices, measured: PositionMeasurement) -> Floats:
    """Update all filters of `rows`, in place; return the log of the ratio of both likelihoods before that."""
    s, ratio = _rows(table), np.empty(len(rows))
    for k, i in enumerate(rows):
        ratio[k] = _log_likelihood(s.place[:, i], s.place_variance[:, i], measured, k)
        ratio[k] -= _log_likelihood(s.position[:, i], s.variance[:, i], measured, k)
        for axis in range(2):
            place = measured.position[axis, k]
            noise = measured.variance_north[k] if axis == 0 else measured.variance_east[k]
            s.place[axis, i], s.place_variance[axis, i] = axis_kalman.update_constant(
                s.place[axis, i], s.place_variance[axis, i], place, noise
            )
            moved = axis_kalman.update(_moving(s, axis, i), place, noise)
            s.position[axis, i], s.velocity[axis, i] = moved.position, moved.velocity
            s.variance[axis, i] = moved.variance
    return ratio


@kernel
def _log_likelihood(position: Floats, variance: Floats, measured: PositionMeasurement, k: int) -> float:
    """Return the log of the normal density, times 2 pi, of measurement k with its full covariance.

    `position`, `variance`: (2,) north and east, of one hypothesis.
    """
    north, east = measured.position[0, k] - position[0], measured.position[1, k] - position[1]
    s_nn, s_ee = variance[0] + measured.variance_north[k], variance[1] + measured.variance_east[k]
    s_ne = measured.covariance_ne[k]
    determinant = s_nn * s_ee - s_ne**2
    distance: float = (s_ee * north**2 - 2.0 * s_ne * north * east + s_nn * east**2) / determinant
    return -0.5 * (distance + math.log(determinant))


@kernel
def _join(table: Floats, heirs: Indices, old: Indices) -> None:
    s = _rows(table)
    for heir, before in zip(heirs, old):  # noqa: B905  numba knows no `strict`
        for axis in range(2):
            s.place[axis, heir], s.place_variance[axis, heir] = axis_kalman.update_constant(
                s.place[axis, heir], s.place_variance[axis, heir], s.place[axis, before], s.place_variance[axis, before]
            )
