"""The paper's observer: four independent Kalman filters an object, for x, y, z and the radius [SSIE eq. 2].

Whether an object moves at all is decided by evidence: each object is followed by two sets of filters, one for an object
that stays where it is and one for constant velocity, and the ratio of their likelihoods says which one to believe.
"""

import math

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.kernel import kernel
from ods.tracker import kalman
from ods.tracker.belief import Belief
from ods.tracker.columns import Columns
from ods.tracker.life import STATIC
from ods.tracker.measurement import Fix
from ods.tracker.settings import MotionSettings

Rows = NDArray[np.intp]

PLACE, POSITION, PLACE_VARIANCE, VARIANCE, VELOCITY, SLOPE, RESIDUAL = range(0, 21, 3)
"""First of three rows each, for north, east and down: position and its variance if the object does not move (PLACE),
and if it moves POSITION, VELOCITY and the factors of their covariance (see `kalman`)."""
RADIUS, RADIUS_VARIANCE, ODDS = 21, 22, 23
"""ODDS: log of P(static) / P(moving); infinite once settled."""
ROWS = 24

DISPROVED = -5.0
"""Log-odds at which the static hypothesis starts anew from where the moving one is now."""
PROVED = 8.0
"""Largest log-odds, so that an object that starts to move is believed in time."""
REOPENED = 4.0
"""Log-odds, in favour of what was settled, when an object is seen again."""
ESTABLISHED = float(np.log(STATIC / (1.0 - STATIC)))
"""Log-odds, either way, from which there is no doubt whether an object moves;"""
KNOWN_SPEED = 0.4
"""nor is there when its velocity, if it moves, is known to this share of what a new object's is."""
LEAST_VARIANCE = 1e-12


class IndependentObserver:
    """See `ods.tracker.observers.Observer`."""

    def __init__(self, settings: MotionSettings) -> None:
        self._settings = settings
        self._columns = Columns(ROWS, np.float64)
        sigma, vertical = settings.velocity_sigma, settings.vertical_velocity_sigma
        self._new_velocity_variance = np.array([sigma**2, sigma**2, vertical**2])
        self._new_odds = float(np.log(settings.static_prior / (1.0 - settings.static_prior)))

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        motion = self._settings
        _predict(self._columns.data, dt, motion.acceleration_noise, motion.static_noise, motion.radius_noise)

    def belief(self) -> Belief:
        """Return both hypotheses of all objects, the static one first."""
        s = self._columns.data
        weight = _weights(s)
        hypotheses = (2, 3, len(self._columns))
        return Belief(
            weight=weight,
            position=s[PLACE : PLACE + 6].reshape(hypotheses),
            variance=s[PLACE_VARIANCE : PLACE_VARIANCE + 6].reshape(hypotheses),
            covariance_ne=np.zeros(weight.shape),
            radius=s[RADIUS],
            radius_variance=s[RADIUS_VARIANCE],
            static=weight[0],
        )

    def velocity(self) -> tuple[Array, Array]:
        """Return mean and variance (3, n) of all velocities."""
        moments = _velocity(self._columns.data)
        return moments[0], moments[1]

    def start(self, fix: Fix) -> None:
        """Append new objects, one a fix."""
        variance = np.array([fix.north, fix.east, fix.half_height**2 / 3.0])
        self._append(fix.position, variance, fix.radius, fix.radius_variance, self._new_odds)

    def recall(self, position: Array, variance: Array, radius: Array, radius_variance: Array) -> None:
        """Append objects from the map, known not to move: (3, k), (3, k), (k,), (k,)."""
        sure = np.maximum(variance, LEAST_VARIANCE), np.maximum(radius_variance, LEAST_VARIANCE)
        self._append(position, sure[0], radius, sure[1], math.inf)

    def _append(self, position: Array, variance: Array, radius: Array, radius_variance: Array, odds: float) -> None:
        new = np.zeros((ROWS, len(radius)))
        new[PLACE : PLACE + 3] = new[POSITION : POSITION + 3] = position
        new[PLACE_VARIANCE : PLACE_VARIANCE + 3] = new[VARIANCE : VARIANCE + 3] = variance
        new[RESIDUAL : RESIDUAL + 3] = self._new_velocity_variance[:, None]
        new[RADIUS], new[RADIUS_VARIANCE] = radius, radius_variance
        new[ODDS] = odds
        self._columns.append(new)

    def update(self, rows: Rows, fix: Fix, since_s: Array) -> None:
        """Take one fix an object, `since_s` after its last one."""
        _update(self._columns.data, rows, fix, since_s, self._settings.change_rate)

    def settle(self, rows: Rows) -> None:
        """Decide for good whether each object moves, where that is established; in doubt both remain possible."""
        _settle(self._columns.data, rows, (KNOWN_SPEED * self._settings.velocity_sigma) ** 2)

    def rest(self, rows: Rows) -> None:
        """Decide for good that objects do not move: they are where they were when seen."""
        self._columns.data[ODDS, rows] = math.inf

    def reopen(self, rows: Rows) -> None:
        """Take the decision of `settle` back: the hypothesis given up starts anew from the other one."""
        _reopen(self._columns.data, rows, self._new_velocity_variance)

    def inherit(self, heirs: Rows, old: Rows) -> None:
        """Let `heirs` go on with what is settled of `old`, the same objects: those that rest do so where they did."""
        _inherit(self._columns.data, heirs, old)

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Remove the objects where `mask` is False."""
        self._columns.keep(mask)


# The kernels work on the (ROWS, n) table `s`, in place.


@kernel
def _predict(s: Array, dt: float, acceleration_noise: float, static_noise: float, radius_noise: float) -> None:
    for axis in range(3):
        for i in range(s.shape[1]):
            position, variance, slope, residual = kalman.predict(
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
    for i in range(s.shape[1]):
        s[RADIUS_VARIANCE, i] += radius_noise * dt


@kernel
def _static(odds: float) -> float:
    """Return the probability of log-odds."""
    return 0.5 * (1.0 + math.tanh(0.5 * odds))


@kernel
def _weights(s: Array) -> Array:
    """Return (2, n) probabilities of the static and of the moving hypothesis."""
    weights = np.empty((2, s.shape[1]))
    for i in range(s.shape[1]):
        weights[0, i] = _static(s[ODDS, i])
        weights[1, i] = 1.0 - weights[0, i]
    return weights


@kernel
def _velocity(s: Array) -> Array:
    """Return (2, 3, n) mean and variance of the mixture's velocities; the static hypothesis has velocity 0."""
    moments = np.empty((2, 3, s.shape[1]))
    for axis in range(3):
        for i in range(s.shape[1]):
            moving, velocity = 1.0 - _static(s[ODDS, i]), s[VELOCITY + axis, i]
            variance = kalman.velocity_variance(s[VARIANCE + axis, i], s[SLOPE + axis, i], s[RESIDUAL + axis, i])
            mean = moving * velocity
            moments[0, axis, i] = mean
            moments[1, axis, i] = moving * (variance + velocity**2) - mean**2
    return moments


@kernel
def _update(s: Array, rows: Rows, fix: Fix, since_s: Array, change_rate: float) -> None:
    """Update all filters of `rows`, and the log-odds by the likelihoods of the fixes before that."""
    for k, i in enumerate(rows):
        static = _static(s[ODDS, i])
        static += change_rate * min(since_s[k], 1.0) * (1.0 - 2.0 * static)
        odds = math.log(static / (1.0 - static))
        odds += _log_likelihood(s, PLACE, PLACE_VARIANCE, i, fix, k) - _log_likelihood(s, POSITION, VARIANCE, i, fix, k)
        _update_horizontal(s, i, fix, k)
        _update_height(s, i, fix.position[2, k], fix.half_height[k])
        s[RADIUS, i], s[RADIUS_VARIANCE, i] = kalman.update_constant(
            s[RADIUS, i], s[RADIUS_VARIANCE, i], fix.radius[k] - s[RADIUS, i], fix.radius_variance[k]
        )
        if odds < DISPROVED:
            for axis in range(3):
                s[PLACE + axis, i], s[PLACE_VARIANCE + axis, i] = s[POSITION + axis, i], s[VARIANCE + axis, i]
        s[ODDS, i] = min(max(odds, DISPROVED), PROVED)


@kernel
def _log_likelihood(s: Array, position: int, variance: int, i: int, fix: Fix, k: int) -> float:
    """Return the log of the normal density, times 2 pi, of fix k in the horizontal plane with its full covariance.

    `position`, `variance`: rows of the hypothesis of object i.
    """
    north, east = fix.position[0, k] - s[position, i], fix.position[1, k] - s[position + 1, i]
    s_nn, s_ee, s_ne = s[variance, i] + fix.north[k], s[variance + 1, i] + fix.east[k], fix.mixed[k]
    determinant = s_nn * s_ee - s_ne**2
    distance: float = (s_ee * north**2 - 2.0 * s_ne * north * east + s_nn * east**2) / determinant
    return -0.5 * (distance + math.log(determinant))


@kernel
def _update_horizontal(s: Array, i: int, fix: Fix, k: int) -> None:
    for axis in range(2):
        measured, noise = fix.position[axis, k], fix.north[k] if axis == 0 else fix.east[k]
        place, position, velocity = s[PLACE + axis, i], s[POSITION + axis, i], s[VELOCITY + axis, i]
        s[PLACE + axis, i], s[PLACE_VARIANCE + axis, i] = kalman.update_constant(
            place, s[PLACE_VARIANCE + axis, i], measured - place, noise
        )
        s[POSITION + axis, i], s[VELOCITY + axis, i], s[VARIANCE + axis, i] = kalman.update(
            position, velocity, s[VARIANCE + axis, i], s[SLOPE + axis, i], measured - position, noise
        )


@kernel
def _update_height(s: Array, i: int, middle: float, half: float) -> None:
    """Take in that object i is inside the fan, `half` above or below its `middle`.

    Each ping tells the same once more, so that it must not count as new each time: a height inside the fan's interval
    stays, one outside moves to its edge, and the variance is at most that of an object anywhere in the interval.
    """
    for height, variance in ((PLACE + 2, PLACE_VARIANCE + 2), (POSITION + 2, VARIANCE + 2)):
        step = min(max(s[height, i], middle - half), middle + half) - s[height, i]
        s[height, i] += step
        if height == POSITION + 2:
            s[VELOCITY + 2, i] += s[SLOPE + 2, i] * step
        s[variance, i] = min(s[variance, i] + step**2, half**2 / 3.0)


@kernel
def _settle(s: Array, rows: Rows, known_variance: float) -> None:
    for i in rows:
        north = kalman.velocity_variance(s[VARIANCE, i], s[SLOPE, i], s[RESIDUAL, i])
        east = kalman.velocity_variance(s[VARIANCE + 1, i], s[SLOPE + 1, i], s[RESIDUAL + 1, i])
        if abs(s[ODDS, i]) >= ESTABLISHED or max(north, east) <= known_variance:
            s[ODDS, i] = math.copysign(math.inf, s[ODDS, i])


@kernel
def _reopen(s: Array, rows: Rows, new_velocity_variance: Array) -> None:
    for i in rows:
        if not math.isinf(s[ODDS, i]):
            continue
        static = s[ODDS, i] > 0.0
        s[ODDS, i] = REOPENED if static else -REOPENED
        for axis in range(3):
            if static:
                s[POSITION + axis, i], s[VARIANCE + axis, i] = s[PLACE + axis, i], s[PLACE_VARIANCE + axis, i]
                s[VELOCITY + axis, i], s[SLOPE + axis, i] = 0.0, 0.0
                s[RESIDUAL + axis, i] = new_velocity_variance[axis]
            else:
                s[PLACE + axis, i], s[PLACE_VARIANCE + axis, i] = s[POSITION + axis, i], s[VARIANCE + axis, i]


@kernel
def _inherit(s: Array, heirs: Rows, old: Rows) -> None:
    for heir, before in zip(heirs, old):  # noqa: B905  numba knows no `strict`
        if s[ODDS, before] == math.inf:
            s[ODDS, heir] = min(s[ODDS, heir] + REOPENED, PROVED)
            for axis in range(2):
                place, rest = s[PLACE + axis, heir], s[PLACE + axis, before]
                s[PLACE + axis, heir], s[PLACE_VARIANCE + axis, heir] = kalman.update_constant(
                    place, s[PLACE_VARIANCE + axis, heir], rest - place, s[PLACE_VARIANCE + axis, before]
                )
