"""Whether an object moves at all, decided by evidence: what all observers share [SSIE eq. 2].

Each object is followed by filters for one that stays where it is and by filters for one that moves, and the ratio of
their likelihoods says which to believe. How north and east are filtered is what observers differ in (`horizontal`);
height and radius have filters of their own (`common`).
"""

import math
from typing import Any

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTable
from ods.tracker.observer import common
from ods.tracker.observer.belief import Belief
from ods.tracker.observer.common import DISPROVED, LEAST_VARIANCE, PROVED, CommonState, NewCommon, Velocities
from ods.tracker.observer.horizontal import RESTING, HorizontalFilter, KindsOfMotion, NewPlaces
from ods.tracker.observer.sensitivity import Heights
from ods.tracker.settings import STATIC, MotionSettings

REOPENED = 4.0
"""Log-odds, in favour of what was settled, when an object is seen again."""
ESTABLISHED = float(np.log(STATIC / (1.0 - STATIC)))
"""Log-odds, either way, from which there is no doubt whether an object moves;"""
KNOWN_SPEED = 0.4
"""nor is there when its velocity, if it moves, is known to this share of what a new object's is,"""
CREEPING = 0.1
"""and one that might move, but no faster than this share (root mean square), rests: such a motion is mostly made by
chance, or by what pings share, of one that rests."""


class StaticOrMovingObserver:
    """See `ods.tracker.observer.registry.Observer`."""

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
        self._horizontal.predict(dt)
        common.predict(self._table.table, dt, motion.acceleration_noise, motion.static_noise, motion.radius_noise)

    def belief(self) -> Belief:
        """Return all hypotheses of all objects, the static one first."""
        s, horizontal = self._table.rows, self._horizontal.state()
        weight, position, variance, by_height, shared = common.moments(self._table.table, horizontal)
        return Belief(
            weight=weight,
            position=position,
            variance=variance,
            covariance_ne=horizontal.covariance_ne,
            by_height=by_height,
            shared=shared,
            radius=s.radius,
            radius_variance=s.radius_variance,
            static=weight[RESTING],
            restless=self._restless(),
        )

    def static(self) -> Floats:
        """Return (n,) the probability that each object does not move."""
        return common.all_static(self._table.rows.odds)

    def _restless(self) -> Floats | None:
        if self._kinds is None:
            return None
        return self._kinds.acceleration_noise() - self._settings.acceleration_noise

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (3, n) of all velocities.

        At rest the mean is 0, but what echoes cannot tell from that yet is part of the variance, whatever the odds are:
        they weigh rest against velocities of `velocity_sigma`, among which slow ones are few.
        """
        moving = self._horizontal.velocity()
        # A velocity that may change at any time never becomes sure: what rests creeps only if its place speaks for it.
        steady, by_place = (moving, True) if self._kinds is None else (self._kinds.steady(), False)
        mean, variance = common.velocity(
            self._table.table, self._horizontal.state(), Velocities(*moving, *steady), by_place
        )
        return mean, variance

    def start(self, measured: PositionMeasurement) -> None:
        """Append new objects, one a measurement, anywhere in the fan's height."""
        variance = measured.half_height**2 / 3.0
        noise = np.array([measured.variance_north, measured.variance_east])
        self._horizontal.append(NewPlaces(measured.position[:2], noise, measured.covariance_ne, measured.sensitivity))
        alike = measured.position[2], variance, measured.radius, measured.radius_variance
        self._append(NewCommon(*alike, measured.pose_variance, self._new_odds))

    def recall(
        self, position: Floats, variance: Floats, covariance_ne: Floats, radius: Floats, radius_variance: Floats
    ) -> None:
        """Append objects from the map, known not to move: (3, k), (3, k), (k,), (k,), (k,)."""
        variance = np.maximum(variance, LEAST_VARIANCE)
        unseen = np.zeros((UNSEEN, 2, len(radius)))
        self._horizontal.append(NewPlaces(position[:2], variance[:2], covariance_ne, unseen))
        radius_variance = np.maximum(radius_variance, LEAST_VARIANCE)
        self._append(NewCommon(position[2], variance[2], radius, radius_variance, np.zeros(2), math.inf))

    def _append(self, new: NewCommon) -> None:
        first = len(self._table)
        self._table.extend(len(new.radius))
        common.start(self._table.table, first, new, self._settings.vertical_velocity_sigma**2)

    def update(self, rows: Indices, measured: PositionMeasurement, since_s: Floats) -> None:
        """Take one measurement an object, `since_s` after its last one."""
        heights = Named(Heights, common.in_fan(self._table.table, rows, measured.position[2], measured.half_height))
        learned = self._horizontal.update(rows, measured, since_s, heights).table
        seen = measured.radius, measured.radius_variance, measured.pose_variance
        disproved = common.update(
            self._table.table, rows, seen, heights.table, learned, since_s, self._settings.change_rate
        )
        if len(disproved):
            self._horizontal.rest_there(disproved)

    def settle(self, rows: Indices) -> None:
        """Decide for good whether each object moves, where that is established; in doubt both remain possible."""
        if not len(rows):
            return
        odds, unit = self._table.rows.odds, self._settings.velocity_sigma**2
        velocity, variance = (moment[:, rows] for moment in self._horizontal.velocity())
        established = np.abs(odds[rows]) >= ESTABLISHED
        creeping = (velocity**2 + variance).sum(axis=0) <= CREEPING**2 * unit
        rests = creeping | (odds[rows] >= 0.0)
        decided = established | (variance.max(axis=0) <= KNOWN_SPEED**2 * unit)
        odds[rows[decided]] = np.where(rests[decided], np.inf, -np.inf)

    def rest(self, rows: Indices) -> None:
        """Decide for good that objects do not move: they are where they were when seen."""
        self._table.rows.odds[rows] = math.inf

    def reopen(self, rows: Indices) -> None:
        """Take the decision of `settle` back: the hypothesis given up starts anew from the other one."""
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
        """Let `heirs` go on with what is settled of `old`, the same objects: those that rest do so where they did."""
        odds = self._table.rows.odds
        moved = heirs[odds[old] == -math.inf]
        odds[moved] = np.maximum(odds[moved] - REOPENED, DISPROVED)
        rest = odds[old] == math.inf
        heirs, old = heirs[rest], old[rest]
        odds[heirs] = np.minimum(odds[heirs] + REOPENED, PROVED)
        self._horizontal.join(heirs, old)

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        self._table.keep(mask)
        self._horizontal.keep(mask)

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects."""
        return [self._table, *self._horizontal.tables()]
