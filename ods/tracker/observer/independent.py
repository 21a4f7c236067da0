"""The paper's observer: independent Kalman filters for north and east [SSIE eq. 2], in closed form (see `kalman`)."""

import math

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.base.kernel import kernel
from ods.tracker.measurement.model import Fix
from ods.tracker.observer import axis_kalman
from ods.tracker.observer.motion_hypotheses import Places
from ods.tracker.observer.track_table import Columns
from ods.tracker.settings import MotionSettings

PLACE, POSITION, PLACE_VARIANCE, VARIANCE, VELOCITY, SLOPE, RESIDUAL = range(0, 14, 2)
"""First of two rows each, for north and east: position and its variance if the object does not move (PLACE), and if it
moves POSITION, VELOCITY and the factors of their covariance (see `kalman`)."""
ROWS = 14


class IndependentAxes:
    """See `ods.tracker.observer.motion_hypotheses.Plane`."""

    def __init__(self, settings: MotionSettings) -> None:
        self._settings = settings
        self._columns = Columns(ROWS, np.float64)

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        _predict(self._columns.data, dt, self._settings.acceleration_noise, self._settings.static_noise)

    def places(self) -> Places:
        """Return where objects are; the arrays are views."""
        s = self._columns.data
        hypotheses, n = 2, s.shape[1]
        return Places(
            np.ones((1, n)),
            s[PLACE : PLACE + 4].reshape(hypotheses, 2, n),
            s[PLACE_VARIANCE : PLACE_VARIANCE + 4].reshape(hypotheses, 2, n),
            np.zeros((hypotheses, n)),
        )

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""
        return self._columns.data[VELOCITY : VELOCITY + 2], _velocity_variance(self._columns.data)

    def append(self, position: Floats, north: Floats, east: Floats, mixed: Floats) -> None:
        """Append objects at (2 or more, k) positions, their variances (k,); the covariance is left out."""
        new = np.zeros((ROWS, len(north)))
        new[PLACE : PLACE + 2] = new[POSITION : POSITION + 2] = position[:2]
        for rows in (PLACE_VARIANCE, VARIANCE):
            new[rows], new[rows + 1] = north, east
        new[RESIDUAL : RESIDUAL + 2] = self._settings.velocity_sigma**2
        self._columns.append(new)

    def update(self, rows: Indices, fix: Fix, since_s: Floats) -> Floats:
        """Take one fix an object; return (k,) the log of the likelihood if it is static over that if it moves."""
        return _update(self._columns.data, rows, fix)

    def rest_there(self, rows: Indices) -> None:
        """Start the static hypothesis anew where the moving one is now."""
        _copy(self._columns.data, rows, POSITION, PLACE)
        _copy(self._columns.data, rows, VARIANCE, PLACE_VARIANCE)

    def set_out(self, rows: Indices) -> None:
        """Start the moving hypothesis anew where the static one is, with unknown velocity."""
        s = self._columns.data
        _copy(s, rows, PLACE, POSITION)
        _copy(s, rows, PLACE_VARIANCE, VARIANCE)
        s[VELOCITY : VELOCITY + 2, rows] = s[SLOPE : SLOPE + 2, rows] = 0.0
        s[RESIDUAL : RESIDUAL + 2, rows] = self._settings.velocity_sigma**2

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let the static hypotheses of `heirs` learn where those of `old`, the same objects, were."""
        _join(self._columns.data, heirs, old)

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        self._columns.keep(mask)


# The kernels work on the (ROWS, n) table `s`, in place.


@kernel
def _predict(s: Floats, dt: float, acceleration_noise: float, static_noise: float) -> None:
    for axis in range(2):
        for i in range(s.shape[1]):
            position, variance, slope, residual = axis_kalman.predict(
                s[POSITION + axis, i],
                s[VELOCITY + axis, i],
                s[VARIANCE + axis, i],
                s[SLOPE + axis, i],
                s[RESIDUAL + axis, i],
                dt,
                acceleration_noise,
            )
            s[POSITION + axis, i], s[VARIANCE + axis, i] = position, variance
            s[SLOPE + axis, i], s[RESIDUAL + axis, i] = slope, residual
            s[PLACE_VARIANCE + axis, i] += static_noise * dt


@kernel
def _velocity_variance(s: Floats) -> Floats:
    variance = np.empty((2, s.shape[1]))
    for axis in range(2):
        for i in range(s.shape[1]):
            variance[axis, i] = axis_kalman.velocity_variance(
                s[VARIANCE + axis, i], s[SLOPE + axis, i], s[RESIDUAL + axis, i]
            )
    return variance


@kernel
def _update(s: Floats, rows: Indices, fix: Fix) -> Floats:
    """Update all filters of `rows`; return the log of the ratio of both likelihoods of the fixes before that."""
    ratio = np.empty(len(rows))
    for k, i in enumerate(rows):
        ratio[k] = _log_likelihood(s, PLACE, PLACE_VARIANCE, i, fix, k)
        ratio[k] -= _log_likelihood(s, POSITION, VARIANCE, i, fix, k)
        for axis in range(2):
            measured, noise = fix.position[axis, k], fix.north[k] if axis == 0 else fix.east[k]
            place, position, velocity = s[PLACE + axis, i], s[POSITION + axis, i], s[VELOCITY + axis, i]
            s[PLACE + axis, i], s[PLACE_VARIANCE + axis, i] = axis_kalman.update_constant(
                place, s[PLACE_VARIANCE + axis, i], measured - place, noise
            )
            s[POSITION + axis, i], s[VELOCITY + axis, i], s[VARIANCE + axis, i] = axis_kalman.update(
                position, velocity, s[VARIANCE + axis, i], s[SLOPE + axis, i], measured - position, noise
            )
    return ratio


@kernel
def _log_likelihood(s: Floats, position: int, variance: int, i: int, fix: Fix, k: int) -> float:
    """Return the log of the normal density, times 2 pi, of fix k in the horizontal plane with its full covariance.

    `position`, `variance`: rows of the hypothesis of object i.
    """
    north, east = fix.position[0, k] - s[position, i], fix.position[1, k] - s[position + 1, i]
    s_nn, s_ee, s_ne = s[variance, i] + fix.north[k], s[variance + 1, i] + fix.east[k], fix.mixed[k]
    determinant = s_nn * s_ee - s_ne**2
    distance: float = (s_ee * north**2 - 2.0 * s_ne * north * east + s_nn * east**2) / determinant
    return -0.5 * (distance + math.log(determinant))


def _copy(s: Floats, rows: Indices, source: int, target: int) -> None:
    s[target : target + 2, rows] = s[source : source + 2, rows]


@kernel
def _join(s: Floats, heirs: Indices, old: Indices) -> None:
    for heir, before in zip(heirs, old):  # noqa: B905  numba knows no `strict`
        for axis in range(2):
            place, rest = s[PLACE + axis, heir], s[PLACE + axis, before]
            s[PLACE + axis, heir], s[PLACE_VARIANCE + axis, heir] = axis_kalman.update_constant(
                place, s[PLACE_VARIANCE + axis, heir], rest - place, s[PLACE_VARIANCE + axis, before]
            )
