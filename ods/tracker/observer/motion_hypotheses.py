"""Static or moving, decided by evidence: the part that all observers share [SSIE eq. 2].

Each object is followed by filters for one that stays where it is and by filters for one that moves, and the ratio of
their likelihoods says which to believe. How north and east are filtered is what observers differ in (`horizontal`);
height and radius have filters of their own.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.compiled import native
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTable
from ods.tracker.observer.belief import Belief, Estimate
from ods.tracker.observer.horizontal import RESTING, Heights, HorizontalFilter, KindsOfMotion, NewPlaces
from ods.tracker.settings import STATIC, MotionSettings

ESTABLISHED = math.log(STATIC) - math.log1p(-STATIC)
"""Log-odds beyond which it is decided whether an object moves."""
KNOWN_SPEED = 0.4
"""nor is there when its velocity, if it moves, is known to this share of what a new object's is,"""
SLOWEST_MOTION = 0.1
"""and one that might move, but no faster than this share (root mean square), rests: such a motion is mostly made by
chance, or by what pings share, of one that rests."""

STATIC_RESTART_ODDS = -5.0
"""Log-odds at which the static hypothesis restarts where the moving one is now."""
REOPENED = -STATIC_RESTART_ODDS
"""Log-odds of the earlier decision when an object is seen again."""
MAX_STATIC_ODDS = 8.0
"""Largest log-odds, so that an object that starts to move is recognized in time."""
LEAST_VARIANCE = 1e-12


class CommonState(NamedTuple):
    """State of n objects that all observers filter alike: (n,) each."""

    rest_height: Floats
    """Down, if the object does not move;"""
    rest_height_variance: Floats
    height: Floats
    """and if it moves,"""
    height_variance: Floats
    climb: Floats
    """with a velocity, and the other factors of the covariance (see `axis_kalman`):"""
    slope: Floats
    residual: Floats
    radius: Floats
    radius_variance: Floats
    odds: Floats
    """Log of P(static) / P(moving); infinite once settled."""
    pose_north: Floats
    """Variance of the vehicle's own position when the object was last seen, m^2: it is a bias, which echoes share."""
    pose_east: Floats
    rest_square: Floats
    """What is known of the square of the height, about its mean: mean and variance (`Heights`)."""
    rest_square_variance: Floats
    square: Floats
    """And if it moves."""
    square_variance: Floats


class StaticOrMovingObserver:
    """An observer. It keeps one column an object; `rows` are indices of objects.

    Objects that end are removed from `tables`, and new ones appended there, before `start` or `recall` fills them in.
    """

    def __init__(
        self, settings: MotionSettings, horizontal: HorizontalFilter, kinds: KindsOfMotion | None = None
    ) -> None:
        """`kinds`: the same filter, if it follows objects by several kinds of motion, of which the first is steady."""
        self._settings = settings
        self._horizontal = horizontal
        self._kinds = kinds
        self._table = TrackTable(CommonState, (len(CommonState._fields),))
        self._new_odds = float(np.log(settings.static_prior / (1.0 - settings.static_prior)))

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        motion = self._settings
        noise = motion.acceleration_noise, motion.static_noise, motion.radius_noise
        self._horizontal.predict(dt)
        native.common_predict(self._table.table, dt, noise)

    def belief_and_moments(self) -> tuple[Belief, Estimate]:
        """Return all hypotheses of all objects, the static one first; the arrays may be views that the next change
        spoils."""
        s, horizontal = self._table.rows, self._horizontal.state()
        hypotheses, n = horizontal.covariance_ne.shape
        weight, by_height = np.empty((hypotheses, n)), np.empty((hypotheses, 2, n))
        position, variance, shared = np.empty((3, hypotheses, 3, n))
        mean, spread, all_share = np.empty((3, 3, n))
        both = mean, spread, np.empty(n), np.empty((2, n)), all_share
        native.belief_and_moments(self._table.table, horizontal, weight, position, variance, by_height, shared, both)
        size_and_rest = s.radius, s.radius_variance, weight[RESTING]
        restless = np.zeros(n)
        if self._kinds is not None:
            restless = self._kinds.noise @ horizontal.share - self._settings.acceleration_noise
        belief = weight, position, variance, horizontal.covariance_ne, by_height, shared, *size_and_rest, restless
        return Belief(*belief), Estimate(*both, *size_and_rest)

    def static(self) -> Floats:
        """Return (n,) the probability that each object does not move: that of the belief, which is more work."""
        odds = self._table.rows.odds
        static = np.empty(len(odds))
        native.all_static(odds, static)
        return static

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (3, n) of all velocities.

        For the static hypothesis the mean is 0, but what echoes cannot distinguish from that yet is part of the
        variance, whatever the odds are: they weigh rest against velocities of `velocity_sigma`, among which slow ones
        are few.
        """
        moving, moments = self._horizontal.velocity(), np.empty((2, 3, len(self._table)))
        # A velocity that may change at any time never becomes sure: what rests creeps only if its place speaks for it.
        steady, by_place = (moving, True) if self._kinds is None else (self._kinds.steady(), False)
        native.velocities(self._table.table, self._horizontal.state(), moving, steady, by_place, moments)
        mean, variance = moments
        return mean, variance

    def start(self, measured: PositionMeasurement) -> None:
        """Fill in the last objects, one a measurement, anywhere in the fan's height."""
        variance = measured.half_height**2 / 3.0
        noise = np.array([measured.variance_north, measured.variance_east])
        self._horizontal.start(NewPlaces(measured.position[:2], noise, measured.covariance_ne, measured.sensitivity))
        alike = measured.position[2], variance, measured.radius, measured.radius_variance, measured.pose_variance
        native.common_start(self._table.table, alike, self._new_odds, self._settings.vertical_velocity_sigma**2)

    def recall(
        self, position: Floats, variance: Floats, covariance_ne: Floats, radius: Floats, radius_variance: Floats
    ) -> None:
        """Fill in the last objects, from the map, known not to move: (3, k), (3, k), (k,), (k,), (k,)."""
        variance = np.maximum(variance, LEAST_VARIANCE)
        unseen = np.zeros((UNSEEN, 2, len(radius)))
        self._horizontal.start(NewPlaces(position[:2], variance[:2], covariance_ne, unseen))
        alike = position[2], variance[2], radius, np.maximum(radius_variance, LEAST_VARIANCE), np.zeros(2)
        native.common_start(self._table.table, alike, math.inf, self._settings.vertical_velocity_sigma**2)

    def update(self, rows: Indices, measured: PositionMeasurement, since_s: Floats) -> None:
        """Take one measurement an object, `since_s` after its last one."""
        table, heights = self._table.table, np.empty((5, 2, len(rows)))
        native.in_fan(table, rows, measured.position[2], measured.half_height, heights)
        learned = self._horizontal.update(rows, measured, since_s, Named(Heights, heights)).table
        seen = measured.radius, measured.radius_variance, measured.pose_variance
        limits, disproved = (LEAST_VARIANCE, STATIC_RESTART_ODDS, MAX_STATIC_ODDS), np.empty(len(rows), np.intp)
        given = self._settings.change_rate, limits
        count = native.common_update(table, rows, seen, heights, learned, since_s, given, disproved)
        if count:
            self._horizontal.rest_there(disproved[:count])

    def settle(self, rows: Indices) -> None:
        """Decide for good whether each object moves, where that is established; otherwise both remain possible."""
        if not len(rows):
            return
        odds, unit = self._table.rows.odds, self._settings.velocity_sigma**2
        velocity, variance = (moment[:, rows] for moment in self._horizontal.velocity())
        established = np.abs(odds[rows]) >= ESTABLISHED
        creeping = (velocity**2 + variance).sum(axis=0) <= SLOWEST_MOTION**2 * unit
        rests = creeping | (odds[rows] >= 0.0)
        decided = established | (variance.max(axis=0) <= KNOWN_SPEED**2 * unit)
        odds[rows[decided]] = np.where(rests[decided], np.inf, -np.inf)

    def rest(self, rows: Indices) -> None:
        """Decide for good that objects do not move: they are where they were when seen."""
        self._table.rows.odds[rows] = math.inf

    def reopen(self, rows: Indices) -> None:
        """Take the decision of `settle` back: the dropped hypothesis restarts from the other one."""
        if not len(rows):
            return
        s = self._table.rows
        rested, moved = rows[s.odds[rows] == math.inf], rows[s.odds[rows] == -math.inf]
        s.odds[rested], s.odds[moved] = REOPENED, -REOPENED
        s.height[rested], s.height_variance[rested] = s.rest_height[rested], s.rest_height_variance[rested]
        s.rest_height[moved], s.rest_height_variance[moved] = s.height[moved], s.height_variance[moved]
        s.square[rested], s.square_variance[rested] = s.rest_square[rested], s.rest_square_variance[rested]
        s.rest_square[moved], s.rest_square_variance[moved] = s.square[moved], s.square_variance[moved]
        s.climb[rested] = s.slope[rested] = 0.0
        s.residual[rested] = self._settings.vertical_velocity_sigma**2
        self._horizontal.set_out(rested)
        self._horizontal.rest_there(moved)

    def inherit(self, heirs: Indices, old: Indices) -> None:
        """Let `heirs` inherit what is settled of `old`, the same objects: those that rest do so where they did."""
        odds = self._table.rows.odds
        moved = heirs[odds[old] == -math.inf]
        odds[moved] = np.maximum(odds[moved] - REOPENED, STATIC_RESTART_ODDS)
        rest = odds[old] == math.inf
        heirs, old = heirs[rest], old[rest]
        odds[heirs] = np.minimum(odds[heirs] + REOPENED, MAX_STATIC_ODDS)
        self._horizontal.join(heirs, old)

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects."""
        return [self._table, *self._horizontal.tables()]
