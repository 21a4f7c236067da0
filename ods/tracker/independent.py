"""The paper's observer: four independent Kalman filters an object, for x, y, z and the radius [SSIE eq. 2].

Whether an object moves at all is decided by evidence: each object is followed by two sets of filters, one for an object
that stays where it is and one for constant velocity, and the ratio of their likelihoods says which one to believe.
"""

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.tracker import kalman
from ods.tracker.belief import Belief
from ods.tracker.columns import Columns
from ods.tracker.life import STATIC
from ods.tracker.measurement import Fix
from ods.tracker.settings import MotionSettings

Rows = NDArray[np.intp]

PLACE = slice(0, 3)
"""Position of the object if it does not move, NED,"""
POSITION = slice(3, 6)
"""and if it moves;"""
PLACE_VARIANCE = slice(6, 9)
"""variance of the position if it does not move,"""
VARIANCE = slice(9, 12)
VELOCITY = slice(12, 15)
SLOPE = slice(15, 18)
RESIDUAL = slice(18, 21)
"""and if it moves, the factors of the covariance (see `kalman`)."""
RADIUS, RADIUS_VARIANCE, ODDS = 21, 22, 23
"""ODDS: log of P(static) / P(moving); infinite once settled."""
ROWS = 24

DISPROVED = -5.0
"""Log-odds at which the static hypothesis starts anew from where the moving one is now."""
PROVED = 8.0
"""Largest log-odds, so that an object that starts to move is believed in time."""
REOPENED = 3.0
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
        self._new_velocity_variance = np.array([[sigma**2], [sigma**2], [vertical**2]])
        self._new_odds = float(np.log(settings.static_prior / (1.0 - settings.static_prior)))

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        s, motion = self._columns.data, self._settings
        kalman.predict(s[POSITION], s[VELOCITY], s[VARIANCE], s[SLOPE], s[RESIDUAL], dt, motion.acceleration_noise)
        s[PLACE_VARIANCE] += motion.static_noise * dt
        s[RADIUS_VARIANCE] += motion.radius_noise * dt

    def belief(self) -> Belief:
        """Return both hypotheses of all objects, the static one first."""
        s = self._columns.data
        static = _probability(s[ODDS])
        hypotheses = (2, 3, len(static))
        return Belief(
            weight=np.array([static, 1.0 - static]),
            position=s[0:6].reshape(hypotheses).swapaxes(0, 1),
            variance=s[6:12].reshape(hypotheses).swapaxes(0, 1),
            covariance_ne=np.zeros((2, len(static))),
            radius=s[RADIUS],
            radius_variance=s[RADIUS_VARIANCE],
            static=static,
        )

    def velocity(self) -> tuple[Array, Array]:
        """Return mean and variance (3, n) of all velocities."""
        s = self._columns.data
        moving = 1.0 - _probability(s[ODDS])
        mean = moving * s[VELOCITY]
        variance = kalman.velocity_variance(s[VARIANCE], s[SLOPE], s[RESIDUAL])
        return mean, moving * (variance + s[VELOCITY] ** 2) - mean**2

    def start(self, fix: Fix) -> None:
        """Append new objects, one a fix."""
        new = np.zeros((ROWS, len(fix.radius)))
        new[PLACE] = new[POSITION] = fix.position
        new[PLACE_VARIANCE] = new[VARIANCE] = np.array([fix.north, fix.east, fix.half_height**2 / 3.0])
        new[RESIDUAL] = self._new_velocity_variance
        new[RADIUS], new[RADIUS_VARIANCE] = fix.radius, fix.radius_variance
        new[ODDS] = self._new_odds
        self._columns.append(new)

    def recall(self, position: Array, variance: Array, radius: Array, radius_variance: Array) -> None:
        """Append objects from the map, known not to move: (3, k), (3, k), (k,), (k,)."""
        new = np.zeros((ROWS, len(radius)))
        new[PLACE] = new[POSITION] = position
        new[PLACE_VARIANCE] = new[VARIANCE] = np.maximum(variance, LEAST_VARIANCE)
        new[RESIDUAL] = self._new_velocity_variance
        new[RADIUS], new[RADIUS_VARIANCE] = radius, np.maximum(radius_variance, LEAST_VARIANCE)
        new[ODDS] = np.inf
        self._columns.append(new)

    def update(self, rows: Rows, fix: Fix, since_s: Array) -> None:
        """Take one fix an object, `since_s` after its last one."""
        s = self._columns.data[:, rows]
        static = _probability(s[ODDS])
        static += self._settings.change_rate * np.minimum(since_s, 1.0) * (1.0 - 2.0 * static)
        if_static = _log_likelihood(s[PLACE], s[PLACE_VARIANCE], fix)
        if_moving = _log_likelihood(s[POSITION], s[VARIANCE], fix)
        odds = np.log(static / (1.0 - static)) + if_static - if_moving
        _update_axes(s, fix)
        disproved = odds < DISPROVED
        if disproved.any():
            s[PLACE] = np.where(disproved, s[POSITION], s[PLACE])
            s[PLACE_VARIANCE] = np.where(disproved, s[VARIANCE], s[PLACE_VARIANCE])
        s[ODDS] = np.minimum(np.maximum(odds, DISPROVED), PROVED)
        self._columns.data[:, rows] = s

    def settle(self, rows: Rows) -> None:
        """Decide for good whether each object moves, where that is established; in doubt both remain possible."""
        s = self._columns.data[:, rows]
        odds = s[ODDS]
        speed_variance = kalman.velocity_variance(s[VARIANCE], s[SLOPE], s[RESIDUAL])[:2].max(axis=0)
        known = speed_variance <= (KNOWN_SPEED * self._settings.velocity_sigma) ** 2
        decided = (np.abs(odds) >= ESTABLISHED) | known
        self._columns.data[ODDS, rows] = np.where(decided, np.copysign(np.inf, odds), odds)

    def reopen(self, rows: Rows) -> None:
        """Take the decision of `settle` back: the hypothesis given up starts anew from the other one."""
        rows = rows[np.isinf(self._columns.data[ODDS, rows])]
        if not len(rows):
            return
        s = self._columns.data[:, rows]
        static = s[ODDS] > 0.0
        s[PLACE] = np.where(static, s[PLACE], s[POSITION])
        s[PLACE_VARIANCE] = np.where(static, s[PLACE_VARIANCE], s[VARIANCE])
        s[POSITION] = s[PLACE]
        s[VARIANCE] = s[PLACE_VARIANCE]
        s[VELOCITY] = np.where(static, 0.0, s[VELOCITY])
        s[SLOPE] = np.where(static, 0.0, s[SLOPE])
        s[RESIDUAL] = np.where(static, self._new_velocity_variance, s[RESIDUAL])
        s[ODDS] = np.where(static, REOPENED, -REOPENED)
        self._columns.data[:, rows] = s

    def inherit(self, heirs: Rows, old: Rows) -> None:
        """Let `heirs` go on with what is settled of `old`, the same objects: those that rest do so where they did."""
        s, before = self._columns.data[:, heirs], self._columns.data[:, old]
        rests = before[ODDS] == np.inf
        for axis in (0, 1):
            place, variance = s[axis].copy(), s[6 + axis].copy()
            kalman.update_constant(place, variance, before[axis] - place, before[6 + axis])
            s[axis], s[6 + axis] = np.where(rests, place, s[axis]), np.where(rests, variance, s[6 + axis])
        s[ODDS] = np.where(rests, np.minimum(s[ODDS] + REOPENED, PROVED), s[ODDS])
        self._columns.data[:, heirs] = s

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Remove the objects where `mask` is False."""
        self._columns.keep(mask)


def _probability(odds: Array) -> Array:
    return 0.5 * (1.0 + np.tanh(0.5 * odds))


def _log_likelihood(position: Array, variance: Array, fix: Fix) -> Array:
    """Return (k,) log of the normal density of each fix, in the horizontal plane with its full noise covariance."""
    north, east = fix.position[0] - position[0], fix.position[1] - position[1]
    s_nn, s_ee, s_ne = variance[0] + fix.north, variance[1] + fix.east, fix.mixed
    determinant = s_nn * s_ee - s_ne**2
    distance = (s_ee * north**2 - 2.0 * s_ne * north * east + s_nn * east**2) / determinant
    return np.asarray(-0.5 * (distance + np.log(determinant)) - np.log(2.0 * np.pi))


def _update_axes(s: Array, fix: Fix) -> None:
    """Measurement update of all filters of (ROWS, k) columns, in place."""
    noise = np.array([fix.north, fix.east])
    horizontal = fix.position[:2]
    place, position = s[0:2], s[3:5]
    kalman.update_constant(place, s[6:8], horizontal - place, noise)
    kalman.update(position, s[12:14], s[9:11], s[15:17], horizontal - position, noise)
    kalman.update_constant(s[RADIUS], s[RADIUS_VARIANCE], fix.radius - s[RADIUS], fix.radius_variance)
    _update_height(s[2], None, s[8], None, fix)
    _update_height(s[5], s[14], s[11], s[17], fix)


def _update_height(height: Array, speed: Array | None, variance: Array, slope: Array | None, fix: Fix) -> None:
    """Take in that the object is inside the fan, in place.

    Each ping tells the same once more, so that it must not count as new each time: a height inside the fan's interval
    stays, one outside moves to its edge, and the variance is at most that of an object anywhere in the interval.
    """
    inside = np.minimum(np.maximum(height, fix.position[2] - fix.half_height), fix.position[2] + fix.half_height)
    innovation = inside - height
    height[...] = inside
    if speed is not None and slope is not None:
        speed += slope * innovation
    variance[...] = np.minimum(variance + innovation**2, fix.half_height**2 / 3.0)
