"""Whether an object moves at all, decided by evidence: what all observers share [SSIE eq. 2].

Each object is followed by filters for one that stays where it is and by filters for one that moves, and the ratio of
their likelihoods says which to believe. How north and east are filtered is what observers differ in
(`HorizontalFilter`); height and radius have filters of their own.
"""

import math
from typing import Any, NamedTuple, Protocol

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled.kernel import inlined, kernel
from ods.tracker.measurement.model import HEIGHT, UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTable
from ods.tracker.observer import axis_kalman, sensitivity
from ods.tracker.observer.axis_kalman import AxisState
from ods.tracker.observer.belief import Belief
from ods.tracker.observer.creep import Unseen, creep
from ods.tracker.observer.sensitivity import VELOCITY, Heights
from ods.tracker.settings import STATIC, MotionSettings

RESTING = 0
"""The first hypothesis; those after it are kinds of motion."""

DISPROVED = -5.0
"""Log-odds at which the static hypothesis starts anew from where the moving one is now."""
PROVED = 8.0
"""Largest log-odds, so that an object that starts to move is believed in time."""
REOPENED = 4.0
"""Log-odds, in favour of what was settled, when an object is seen again."""
ESTABLISHED = float(np.log(STATIC / (1.0 - STATIC)))
"""Log-odds, either way, from which there is no doubt whether an object moves;"""
KNOWN_SPEED = 0.4
"""nor is there when its velocity, if it moves, is known to this share of what a new object's is,"""
CREEPING = 0.1
"""and one that might move, but no faster than this share (root mean square), rests: such a motion is mostly made by
chance, or by what pings share, of one that rests."""
LEAST_VARIANCE = 1e-12


class HorizontalState(NamedTuple):
    """Where objects are, north and east: the static hypothesis first, then those of moving ones."""

    share: Floats
    """(h - 1, n) probability of each hypothesis of an object that moves; they sum to 1."""
    position: Floats
    """(h, 2, n)."""
    variance: Floats
    """(h, 2, n)."""
    covariance_ne: Floats
    """(h, n)."""
    unseen: Floats
    """(h, UNSEEN, STATE, n) derivatives of the states by what is not seen (`sensitivity`)."""


class NewPlaces(NamedTuple):
    """Of k new objects."""

    position: Floats
    """(2, k) north and east."""
    variance: Floats
    """(2, k)."""
    covariance_ne: Floats
    """(k,)."""
    sensitivity: Floats
    """(UNSEEN, 2, k) derivatives of the position."""


class Learned(NamedTuple):
    """What k measurements say beyond north and east: (2, k) each, if the objects rest and if they move."""

    log_likelihood: Floats
    """Of the measurement, but for a number that both share."""
    step: Floats
    """By which the height is another,"""
    variance: Floats
    """and its variance then,"""
    square: Floats
    """and the same of the height's square, as in `Heights`."""
    square_variance: Floats


@kernel
def learned_rows(table: Floats) -> Learned:
    """Name the rows of a (5, 2, k) table."""
    return Learned(table[0], table[1], table[2], table[3], table[4])


class HorizontalFilter(Protocol):
    """Filters for north and east of all objects, static and moving. `rows` are indices of objects."""

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""

    def state(self) -> HorizontalState:
        """Return where objects are; the arrays may be views that the next change spoils."""

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""

    def append(self, new: NewPlaces) -> None:
        """Append objects whose velocity is unknown."""

    def update(
        self, rows: Indices, measured: PositionMeasurement, since_s: Floats, heights: Named[Heights]
    ) -> Named[Learned]:
        """Take one measurement an object; `since_s`: (k,) time since its last one."""

    def rest_there(self, rows: Indices) -> None:
        """Start the static hypothesis anew where the moving one is now."""

    def set_out(self, rows: Indices) -> None:
        """Start the moving hypothesis anew where the static one is, with unknown velocity."""

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let the static hypotheses of `heirs` learn where those of `old`, the same objects, were."""

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects."""


class CommonState(NamedTuple):
    """What all observers filter alike of n objects: (n,) each."""

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
    """What is known of the square of the height, about its mean: mean and variance (`sensitivity.Heights`)."""
    rest_square_variance: Floats
    square: Floats
    """And if it moves."""
    square_variance: Floats


@kernel
def _rows(table: Floats) -> CommonState:
    return CommonState(
        table[0],
        table[1],
        table[2],
        table[3],
        table[4],
        table[5],
        table[6],
        table[7],
        table[8],
        table[9],
        table[10],
        table[11],
        table[12],
        table[13],
        table[14],
        table[15],
    )


class NewCommon(NamedTuple):
    """Of k new objects."""

    height: Floats
    """(k,)."""
    variance: Floats
    """(k,) of the height."""
    radius: Floats
    """(k,)."""
    radius_variance: Floats
    """(k,)."""
    pose_variance: Floats
    """(2,), as in `PositionMeasurement`."""
    odds: float


class StaticOrMovingObserver:
    """See `ods.tracker.observer.registry.Observer`."""

    def __init__(self, settings: MotionSettings, horizontal: HorizontalFilter) -> None:
        self._settings = settings
        self._horizontal = horizontal
        self._table = TrackTable(CommonState, (len(CommonState._fields),))
        self._new_odds = float(np.log(settings.static_prior / (1.0 - settings.static_prior)))

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        motion = self._settings
        self._horizontal.predict(dt)
        _predict(self._table.table, dt, motion.acceleration_noise, motion.static_noise, motion.radius_noise)

    def belief(self) -> Belief:
        """Return all hypotheses of all objects, the static one first."""
        s, horizontal = self._table.rows, self._horizontal.state()
        weight, position, variance, by_height, shared = _belief(self._table.table, horizontal)
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
        )

    def static(self) -> Floats:
        """Return (n,) the probability that each object does not move."""
        return _all_static(self._table.rows.odds)

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (3, n) of all velocities."""
        horizontal = self._horizontal.state()
        mean, variance = _velocity(self._table.table, *self._horizontal.velocity(), horizontal.share, horizontal.unseen)
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
        _start(self._table.table, first, new, self._settings.vertical_velocity_sigma**2)

    def update(self, rows: Indices, measured: PositionMeasurement, since_s: Floats) -> None:
        """Take one measurement an object, `since_s` after its last one."""
        heights = Named(Heights, _in_fan(self._table.table, rows, measured.position[2], measured.half_height))
        learned = self._horizontal.update(rows, measured, since_s, heights).table
        seen = measured.radius, measured.radius_variance, measured.pose_variance
        disproved = _update(self._table.table, rows, seen, heights.table, learned, since_s, self._settings.change_rate)
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


@kernel
def _start(table: Floats, first: int, new: NewCommon, climb_variance: float) -> None:
    """Set objects from `first` on."""
    s = _rows(table)
    for k in range(len(new.radius)):
        i, variance = first + k, new.variance[k]
        s.rest_height[i] = s.height[i] = new.height[k]
        s.rest_height_variance[i] = s.height_variance[i] = variance
        s.rest_square_variance[i] = s.square_variance[i] = sensitivity.FOURTH_MOMENT * variance**2
        s.residual[i] = climb_variance
        s.radius[i], s.radius_variance[i], s.odds[i] = new.radius[k], new.radius_variance[k], new.odds
        s.pose_north[i], s.pose_east[i] = new.pose_variance


@kernel
def _predict(table: Floats, dt: float, acceleration_noise: float, static_noise: float, radius_noise: float) -> None:
    s = _rows(table)
    for i in range(table.shape[1]):
        sinking = AxisState(s.height[i], s.climb[i], s.height_variance[i], s.slope[i], s.residual[i])
        sunk = axis_kalman.predict(sinking, dt, acceleration_noise)
        s.height[i], s.height_variance[i] = sunk.position, sunk.variance
        s.slope[i], s.residual[i] = sunk.slope, sunk.residual
        s.rest_height_variance[i] += static_noise * dt
        s.radius_variance[i] += radius_noise * dt


@kernel
def _static(odds: float) -> float:
    """Return the probability of log-odds."""
    return 0.5 * (1.0 + math.tanh(0.5 * odds))


@kernel
def _all_static(odds: Floats) -> Floats:
    static = np.empty(len(odds))
    for i in range(len(odds)):
        static[i] = _static(odds[i])
    return static


@kernel
def _belief(table: Floats, horizontal: HorizontalState) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return weight, position, variance, by_height and shared of `Belief`."""
    s = _rows(table)
    share, place, place_variance, covariance, unseen = horizontal
    hypotheses, _, n = place.shape
    weight, position = np.empty((hypotheses, n)), np.empty((hypotheses, 3, n))
    variance, by_height, shared = (
        np.empty((hypotheses, 3, n)),
        np.empty((hypotheses, 2, n)),
        np.empty((hypotheses, 3, n)),
    )
    for i in range(n):
        weight[RESTING, i] = _static(s.odds[i])
        for h in range(1, hypotheses):
            weight[h, i] = (1.0 - weight[RESTING, i]) * share[h - 1, i]
    for h in range(hypotheses):
        height, height_variance, square, square_variance = s.height, s.height_variance, s.square, s.square_variance
        if h == RESTING:
            height, height_variance = s.rest_height, s.rest_height_variance
            square, square_variance = s.rest_square, s.rest_square_variance
        for i in range(n):
            for axis in range(2):
                position[h, axis, i] = place[h, axis, i]
                variance[h, axis, i] = place_variance[h, axis, i]
                by_height[h, axis, i] = unseen[h, HEIGHT, axis, i]
            position[h, 2, i], variance[h, 2, i] = height[i], height_variance[i]
            nn, ee, ne = sensitivity.shared(unseen, h, i, 0, (height_variance[i], square_variance[i] + square[i] ** 2))
            shared[h, 0, i], shared[h, 1, i], shared[h, 2, i] = nn + s.pose_north[i], ee + s.pose_east[i], ne
    for i in range(n):
        if weight[RESTING, i] < 1.0:
            nn, ee, ne = creep(share, (place, place_variance, covariance), unseen, i, _unseen_at_rest(s, i))
            shared[RESTING, 0, i] += nn
            shared[RESTING, 1, i] += ee
            shared[RESTING, 2, i] += ne
    return weight, position, variance, by_height, shared


@inlined
def _unseen_at_rest(s: CommonState, i: int) -> Unseen:
    lower = s.rest_height[i] - s.height[i]
    variance = s.rest_height_variance[i], s.rest_square_variance[i], 1.0, 1.0
    return Unseen((lower, lower**2, 0.0, 0.0), (0.0, s.rest_square[i], 0.0, 0.0), variance)


@kernel
def _velocity(table: Floats, mean: Floats, variance: Floats, share: Floats, unseen: Floats) -> Floats:
    """Return (2, 3, n) mean and variance of the mixture's velocities; the static hypothesis has velocity 0.

    `mean`, `variance`: (2, n) of north and east if the object moves, at a given height; `share`, `unseen`: of
    `HorizontalState`.
    """
    s, n = _rows(table), table.shape[1]
    moments = np.empty((2, 3, n))
    mixed, spread = moments
    own = np.empty(3)
    for i in range(n):
        squares = s.height_variance[i], s.square_variance[i] + s.square[i] ** 2
        moving = 1.0 - _static(s.odds[i])
        own[0], own[1] = variance[0, i], variance[1, i]
        own[2] = axis_kalman.velocity_variance(s.height_variance[i], s.slope[i], s.residual[i])
        for m in range(len(share)):
            north, east, _ = sensitivity.shared(unseen, 1 + m, i, VELOCITY, squares)
            own[0] += share[m, i] * north
            own[1] += share[m, i] * east
        for axis in range(3):
            velocity = mean[axis, i] if axis < 2 else s.climb[i]
            mixed[axis, i] = moving * velocity
            spread[axis, i] = moving * (own[axis] + (1.0 - moving) * velocity**2)
    return moments


@kernel
def _in_fan(table: Floats, rows: Indices, middle: Floats, half: Floats) -> Floats:
    """Return the fields of `Heights`: (5, 2, k)."""
    s, told = _rows(table), np.empty((5, 2, len(rows)))
    for k, i in enumerate(rows):
        _into_fan(told, RESTING, k, s.rest_height[i], s.rest_height_variance[i], middle[k], half[k])
        _into_fan(told, 1, k, s.height[i], s.height_variance[i], middle[k], half[k])
        told[2, RESTING, k], told[3, RESTING, k] = s.rest_square[i], s.rest_square_variance[i]
        told[2, 1, k], told[3, 1, k] = s.square[i], s.square_variance[i]
    return told


@kernel
def _into_fan(told: Floats, g: int, k: int, height: float, variance: float, middle: float, half: float) -> None:
    """Take in that an object is inside the fan, `half` above or below its `middle`.

    Each ping tells the same once more, so that it must not count as new each time: a height inside the fan's interval
    stays, one outside moves to its edge, and the variance is at most that of an object anywhere in the interval, about
    that height.
    """
    now = min(max(height, middle - half), middle + half)
    left = min(variance + (now - height) ** 2, half**2 / 3.0 + (now - middle) ** 2)
    told[0, g, k], told[1, g, k], told[4, g, k] = now, left, now - height


@kernel
def _update(
    table: Floats,
    rows: Indices,
    seen: tuple[Floats, Floats, Floats],
    height_table: Floats,
    learned_table: Floats,
    since_s: Floats,
    change_rate: float,
) -> Indices:
    """Update height, radius and log-odds of `rows`; return those whose static hypothesis has to start anew.

    `seen`: radius, radius_variance and pose_variance of `PositionMeasurement`, whose other arrays would only cost time.
    """
    s, heights, learned = _rows(table), sensitivity.height_rows(height_table), learned_rows(learned_table)
    radius, radius_variance, pose_variance = seen
    disproved, count = np.empty(len(rows), np.intp), 0
    for k, i in enumerate(rows):
        static = _static(s.odds[i])
        static += change_rate * min(since_s[k], 1.0) * (1.0 - 2.0 * static)
        ratio = learned.log_likelihood[RESTING, k] - learned.log_likelihood[1, k]
        odds = math.log(static / (1.0 - static)) + ratio
        s.rest_height[i] = heights.height[RESTING, k] + learned.step[RESTING, k]
        s.height[i] = heights.height[1, k] + learned.step[1, k]
        # Ranges and bearings tell nothing of the climb: it could be a part of the horizontal velocity just as well.
        # Taken from what they say of the height, each would make the other grow.
        s.climb[i] += s.slope[i] * heights.step[1, k]
        s.rest_height_variance[i] = max(learned.variance[RESTING, k], LEAST_VARIANCE)
        s.height_variance[i] = max(learned.variance[1, k], LEAST_VARIANCE)
        s.rest_square[i], s.rest_square_variance[i] = sensitivity.possible_square(
            learned.square[RESTING, k], learned.square_variance[RESTING, k], s.rest_height_variance[i]
        )
        s.square[i], s.square_variance[i] = sensitivity.possible_square(
            learned.square[1, k], learned.square_variance[1, k], s.height_variance[i]
        )
        s.pose_north[i], s.pose_east[i] = pose_variance
        s.radius[i], s.radius_variance[i] = axis_kalman.update_constant(
            s.radius[i], s.radius_variance[i], radius[k], radius_variance[k]
        )
        if odds < DISPROVED:
            s.rest_height[i], s.rest_height_variance[i] = s.height[i], s.height_variance[i]
            s.rest_square[i], s.rest_square_variance[i] = s.square[i], s.square_variance[i]
            disproved[count] = i
            count += 1
        s.odds[i] = min(max(odds, DISPROVED), PROVED)
    return disproved[:count]
