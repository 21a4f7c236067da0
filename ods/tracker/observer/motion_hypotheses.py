"""Whether an object moves at all, decided by evidence: what all observers share [SSIE eq. 2].

Each object is followed by filters for one that stays where it is and by filters for one that moves, and the ratio of
their likelihoods says which to believe. How north and east are filtered is what observers differ in (`Plane`); height
and radius have filters of their own.
"""

import math
from typing import NamedTuple, Protocol

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.base.kernel import kernel
from ods.tracker.measurement.model import Fix
from ods.tracker.observer import axis_kalman
from ods.tracker.observer.belief import Belief
from ods.tracker.observer.track_table import Columns
from ods.tracker.settings import MotionSettings
from ods.tracker.track.lifecycle import STATIC

HEIGHT, HEIGHT_VARIANCE = 0, 2
"""Two rows each, down: if the object does not move, and if it does;"""
CLIMB, SLOPE, RESIDUAL = 4, 5, 6
"""then with a velocity and the factors of the covariance (see `kalman`)."""
RADIUS, RADIUS_VARIANCE, ODDS = 7, 8, 9
"""ODDS: log of P(static) / P(moving); infinite once settled."""
ROWS = 10

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


class Places(NamedTuple):
    """Where objects are, north and east: the static hypothesis first, then those of moving ones."""

    share: Floats
    """(h - 1, n) probability of each hypothesis of an object that moves; they sum to 1."""
    position: Floats
    """(h, 2, n)."""
    variance: Floats
    """(h, 2, n)."""
    covariance_ne: Floats
    """(h, n)."""


class Plane(Protocol):
    """Filters for north and east of all objects, static and moving. `rows` are indices of objects."""

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""

    def places(self) -> Places:
        """Return where objects are; the arrays may be views that the next change spoils."""

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""

    def append(self, position: Floats, north: Floats, east: Floats, mixed: Floats) -> None:
        """Append objects at (2 or more, k) positions, their variances and covariances (k,); the velocity is unknown."""

    def update(self, rows: Indices, fix: Fix, since_s: Floats) -> Floats:
        """Take one fix an object; return (k,) the log of the likelihood if it is static over that if it moves."""

    def rest_there(self, rows: Indices) -> None:
        """Start the static hypothesis anew where the moving one is now."""

    def set_out(self, rows: Indices) -> None:
        """Start the moving hypothesis anew where the static one is, with unknown velocity."""

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let the static hypotheses of `heirs` learn where those of `old`, the same objects, were."""

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""


class StaticOrMovingObserver:
    """See `ods.tracker.observer.registry.Observer`."""

    def __init__(self, settings: MotionSettings, plane: Plane) -> None:
        self._settings = settings
        self._plane = plane
        self._columns = Columns(ROWS, np.float64)
        self._new_odds = float(np.log(settings.static_prior / (1.0 - settings.static_prior)))

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        motion = self._settings
        self._plane.predict(dt)
        _predict(self._columns.data, dt, motion.acceleration_noise, motion.static_noise, motion.radius_noise)

    def belief(self) -> Belief:
        """Return all hypotheses of all objects, the static one first."""
        s, places = self._columns.data, self._plane.places()
        weight, position, variance = _belief(s, places)
        return Belief(
            weight=weight,
            position=position,
            variance=variance,
            covariance_ne=places.covariance_ne,
            radius=s[RADIUS],
            radius_variance=s[RADIUS_VARIANCE],
            static=weight[0],
        )

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (3, n) of all velocities."""
        moments = _velocity(self._columns.data, *self._plane.velocity())
        return moments[0], moments[1]

    def start(self, fix: Fix) -> None:
        """Append new objects, one a fix."""
        self._plane.append(fix.position, fix.north, fix.east, fix.mixed)
        self._append(fix.position[2], fix.half_height**2 / 3.0, fix.radius, fix.radius_variance, self._new_odds)

    def recall(
        self, position: Floats, variance: Floats, covariance_ne: Floats, radius: Floats, radius_variance: Floats
    ) -> None:
        """Append objects from the map, known not to move: (3, k), (3, k), (k,), (k,), (k,)."""
        north, east, down = np.maximum(variance, LEAST_VARIANCE)
        self._plane.append(position, north, east, covariance_ne)
        self._append(position[2], down, radius, np.maximum(radius_variance, LEAST_VARIANCE), math.inf)

    def _append(self, height: Floats, variance: Floats, radius: Floats, radius_variance: Floats, odds: float) -> None:
        new = np.zeros((ROWS, len(radius)))
        new[HEIGHT : HEIGHT + 2], new[HEIGHT_VARIANCE : HEIGHT_VARIANCE + 2] = height, variance
        new[RESIDUAL] = self._settings.vertical_velocity_sigma**2
        new[RADIUS], new[RADIUS_VARIANCE] = radius, radius_variance
        new[ODDS] = odds
        self._columns.append(new)

    def update(self, rows: Indices, fix: Fix, since_s: Floats) -> None:
        """Take one fix an object, `since_s` after its last one."""
        ratio = self._plane.update(rows, fix, since_s)
        disproved = _update(self._columns.data, rows, fix, ratio, since_s, self._settings.change_rate)
        if len(disproved):
            self._plane.rest_there(disproved)

    def settle(self, rows: Indices) -> None:
        """Decide for good whether each object moves, where that is established; in doubt both remain possible."""
        if not len(rows):
            return
        odds = self._columns.data[ODDS, rows]
        known_variance = (KNOWN_SPEED * self._settings.velocity_sigma) ** 2
        known = self._plane.velocity()[1][:, rows].max(axis=0) <= known_variance
        decided = (np.abs(odds) >= ESTABLISHED) | known
        self._columns.data[ODDS, rows[decided]] = np.copysign(np.inf, odds[decided])

    def rest(self, rows: Indices) -> None:
        """Decide for good that objects do not move: they are where they were when seen."""
        self._columns.data[ODDS, rows] = math.inf

    def reopen(self, rows: Indices) -> None:
        """Take the decision of `settle` back: the hypothesis given up starts anew from the other one."""
        if not len(rows):
            return
        s = self._columns.data
        rested, moved = rows[s[ODDS, rows] == math.inf], rows[s[ODDS, rows] == -math.inf]
        s[ODDS, rested], s[ODDS, moved] = REOPENED, -REOPENED
        for row in (HEIGHT, HEIGHT_VARIANCE):
            s[row + 1, rested], s[row, moved] = s[row, rested], s[row + 1, moved]
        s[CLIMB, rested] = s[SLOPE, rested] = 0.0
        s[RESIDUAL, rested] = self._settings.vertical_velocity_sigma**2
        self._plane.set_out(rested)
        self._plane.rest_there(moved)

    def inherit(self, heirs: Indices, old: Indices) -> None:
        """Let `heirs` go on with what is settled of `old`, the same objects: those that rest do so where they did."""
        odds = self._columns.data[ODDS]
        rest = odds[old] == math.inf
        heirs, old = heirs[rest], old[rest]
        odds[heirs] = np.minimum(odds[heirs] + REOPENED, PROVED)
        self._plane.join(heirs, old)

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        self._columns.keep(mask)
        self._plane.keep(mask)


# The kernels work on the (ROWS, n) table `s`, in place.


@kernel
def _predict(s: Floats, dt: float, acceleration_noise: float, static_noise: float, radius_noise: float) -> None:
    for i in range(s.shape[1]):
        s[HEIGHT + 1, i], s[HEIGHT_VARIANCE + 1, i], s[SLOPE, i], s[RESIDUAL, i] = axis_kalman.predict(
            s[HEIGHT + 1, i],
            s[CLIMB, i],
            s[HEIGHT_VARIANCE + 1, i],
            s[SLOPE, i],
            s[RESIDUAL, i],
            dt,
            acceleration_noise,
        )
        s[HEIGHT_VARIANCE, i] += static_noise * dt
        s[RADIUS_VARIANCE, i] += radius_noise * dt


@kernel
def _static(odds: float) -> float:
    """Return the probability of log-odds."""
    return 0.5 * (1.0 + math.tanh(0.5 * odds))


@kernel
def _belief(s: Floats, places: Places) -> tuple[Floats, Floats, Floats]:
    """Return (h, n) probabilities, (h, 3, n) positions and variances of the hypotheses."""
    hypotheses, _, n = places.position.shape
    weight, position = np.empty((hypotheses, n)), np.empty((hypotheses, 3, n))
    variance = np.empty((hypotheses, 3, n))
    for h in range(hypotheses):
        height = min(h, 1)
        for i in range(n):
            static = _static(s[ODDS, i])
            weight[h, i] = static if h == 0 else (1.0 - static) * places.share[h - 1, i]
            for axis in range(2):
                position[h, axis, i], variance[h, axis, i] = places.position[h, axis, i], places.variance[h, axis, i]
            position[h, 2, i], variance[h, 2, i] = s[HEIGHT + height, i], s[HEIGHT_VARIANCE + height, i]
    return weight, position, variance


@kernel
def _velocity(s: Floats, mean: Floats, variance: Floats) -> Floats:
    """Return (2, 3, n) mean and variance of the mixture's velocities; the static hypothesis has velocity 0.

    `mean`, `variance`: (2, n) of north and east if the object moves.
    """
    moments = np.empty((2, 3, s.shape[1]))
    for i in range(s.shape[1]):
        moving = 1.0 - _static(s[ODDS, i])
        climb = axis_kalman.velocity_variance(s[HEIGHT_VARIANCE + 1, i], s[SLOPE, i], s[RESIDUAL, i])
        for axis in range(3):
            velocity, spread = (mean[axis, i], variance[axis, i]) if axis < 2 else (s[CLIMB, i], climb)
            moments[0, axis, i] = moving * velocity
            moments[1, axis, i] = moving * (spread + (1.0 - moving) * velocity**2)
    return moments


@kernel
def _update(s: Floats, rows: Indices, fix: Fix, ratio: Floats, since_s: Floats, change_rate: float) -> Indices:
    """Update height, radius and log-odds of `rows`; return those whose static hypothesis has to start anew.

    `ratio`: log of the likelihood of a fix if the object is static over that if it moves.
    """
    disproved, count = np.empty(len(rows), np.intp), 0
    for k, i in enumerate(rows):
        static = _static(s[ODDS, i])
        static += change_rate * min(since_s[k], 1.0) * (1.0 - 2.0 * static)
        odds = math.log(static / (1.0 - static)) + ratio[k]
        _update_height(s, i, fix.position[2, k], fix.half_height[k])
        s[RADIUS, i], s[RADIUS_VARIANCE, i] = axis_kalman.update_constant(
            s[RADIUS, i], s[RADIUS_VARIANCE, i], fix.radius[k] - s[RADIUS, i], fix.radius_variance[k]
        )
        if odds < DISPROVED:
            s[HEIGHT, i], s[HEIGHT_VARIANCE, i] = s[HEIGHT + 1, i], s[HEIGHT_VARIANCE + 1, i]
            disproved[count] = i
            count += 1
        s[ODDS, i] = min(max(odds, DISPROVED), PROVED)
    return disproved[:count]


@kernel
def _update_height(s: Floats, i: int, middle: float, half: float) -> None:
    """Take in that object i is inside the fan, `half` above or below its `middle`.

    Each ping tells the same once more, so that it must not count as new each time: a height inside the fan's interval
    stays, one outside moves to its edge, and the variance is at most that of an object anywhere in the interval.
    """
    for h in range(2):
        height, variance = s[HEIGHT + h, i], s[HEIGHT_VARIANCE + h, i]
        step = min(max(height, middle - half), middle + half) - height
        s[HEIGHT + h, i] = height + step
        if h == 1:
            s[CLIMB, i] += s[SLOPE, i] * step
        s[HEIGHT_VARIANCE + h, i] = min(variance + step**2, half**2 / 3.0)
