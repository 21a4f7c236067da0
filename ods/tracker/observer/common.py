"""What all observers filter alike: height and radius of objects, and the odds that they rest [SSIE eq. 2]."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.compiled.kernel import inlined, kernel
from ods.tracker.measurement.model import CLIMB, HEIGHT
from ods.tracker.observer import axis_kalman, sensitivity
from ods.tracker.observer.axis_kalman import AxisState
from ods.tracker.observer.creep import Unseen, away, creep
from ods.tracker.observer.horizontal import RESTING, HorizontalState, learned_rows
from ods.tracker.observer.sensitivity import VELOCITY

DISPROVED = -5.0
"""Log-odds at which the static hypothesis starts anew from where the moving one is now."""
PROVED = 8.0
"""Largest log-odds, so that an object that starts to move is believed in time."""
LEAST_VARIANCE = 1e-12


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


@kernel
def start(table: Floats, first: int, new: NewCommon, climb_variance: float) -> None:
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
def predict(table: Floats, dt: float, acceleration_noise: float, static_noise: float, radius_noise: float) -> None:
    """Carry all objects on over `dt` seconds; spectral densities of noise as in `MotionSettings`."""
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
def all_static(odds: Floats) -> Floats:
    """Return (n,) the probabilities of log-odds."""
    static = np.empty(len(odds))
    for i in range(len(odds)):
        static[i] = _static(odds[i])
    return static


@kernel
def moments(table: Floats, horizontal: HorizontalState) -> tuple[Floats, Floats, Floats, Floats, Floats]:
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
            nn, ee, ne = creep(away(share, (place, place_variance, covariance), unseen, i, _unseen_at_rest(s, i)))
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
def velocity(table: Floats, mean: Floats, variance: Floats, share: Floats, unseen: Floats) -> Floats:
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
def crept(table: Floats, mean: Floats, variance: Floats, unseen: Floats) -> Floats:
    """Return (2, n) the mean square of the velocity, north and east, with which objects at rest may creep, m^2/s^2.

    `mean`, `variance`: (2, n) of objects that move, or of those that keep their velocity, at a given height, and
    `unseen` of `HorizontalState`, their kind of motion the first. What creeps is not taken to climb. 0 for those
    settled to rest.
    """
    s, n = _rows(table), table.shape[1]
    square = np.zeros((2, n))
    for i in range(n):
        if s.odds[i] == math.inf:
            continue
        squares = s.height_variance[i], s.square_variance[i] + s.square[i] ** 2
        north, east, _ = sensitivity.shared(unseen, 1, i, VELOCITY, squares, CLIMB)
        square[0, i] = mean[0, i] ** 2 + variance[0, i] + north
        square[1, i] = mean[1, i] ** 2 + variance[1, i] + east
    return square


@kernel
def creeping(table: Floats, horizontal: HorizontalState) -> Floats:
    """Return (n,) the probability that an object at rest creeps, by its place alone (`creep`)."""
    s, n = _rows(table), table.shape[1]
    share, position, variance, covariance, unseen = horizontal
    chance = np.zeros(n)
    for i in range(n):
        chance[i] = away(share, (position, variance, covariance), unseen, i, _unseen_at_rest(s, i)).creeps
    return chance


@kernel
def in_fan(table: Floats, rows: Indices, middle: Floats, half: Floats) -> Floats:
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
def update(
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
