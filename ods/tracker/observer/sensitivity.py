"""What no number of pings averages away: the height that the fan does not resolve, and the bias of the pose.

North and east follow from range and bearing only for a given height, and the bias of the attitude turns them about the
vehicle. Both are the same at every ping. The filters of north and east are those for a given height, and beside them
go the derivatives of what they estimate: by the height, by its square, by the attitude's standard deviation. A filter
is linear in what is measured, so the derivative of its estimate is its answer to the derivative of the measurement: it
is corrected with the same gain. Where the vehicle looks as before, both agree, and the height stays as unknown as it
was; where it moved or turned they differ, and the innovation tells of the height: the separate-bias filter of B.
Friedland, Treatment of bias in recursive filtering, IEEE Trans. Automatic Control 14(4), 1969, which gives what one
large filter would. The attitude is only considered, not estimated (S. F. Schmidt, Application of state-space methods to
navigation problems, Advances in Control Systems 3, 1966), as it is that of all objects. So is the climb of one that
moves: ranges and bearings tell it neither from a horizontal velocity nor from an error of the height.

Tables are (hypotheses, UNSEEN, STATE, n): derivatives of north, east and their velocities.
"""

import math
from typing import NamedTuple

from ods.base.arrays import Floats
from ods.compiled.kernel import inlined, kernel
from ods.tracker.measurement.model import ATTITUDE, BEND, CLIMB, HEIGHT, UNSEEN, PositionMeasurement

STATE = 4
VELOCITY = 2
"""First of the rows of the velocities."""
FOURTH_MOMENT = 1.8
"""Mean of the height's fourth power, from its middle, over the square of its variance: that of an even distribution;"""
MOST_SQUARE = 3.0
"""its largest square, over its variance."""
TINY = 1e-300
"""Keeps 0 / 0 out of what a measurement says that tells nothing."""

Four = tuple[float, float, float, float]


class Place(NamedTuple):
    """North and east with their covariance."""

    north: float
    east: float
    variance_north: float
    variance_east: float
    covariance_ne: float


class Heights(NamedTuple):
    """What an echo's place in the fan says of the heights of the k objects seen: (2, k), at rest and moving."""

    height: Floats
    variance: Floats
    square: Floats
    """What was learned of the square of the height, about that mean: its mean, m^2,"""
    square_variance: Floats
    """and its variance, m^4."""
    step: Floats
    """By which the height changed."""


@kernel
def height_rows(table: Floats) -> Heights:
    """Name the rows of a (5, 2, k) table."""
    return Heights(table[0], table[1], table[2], table[3], table[4])


class Fix(NamedTuple):
    """One measurement, as numbers: handing arrays from kernel to kernel costs more than all that is done with them."""

    north: float
    east: float
    variance_north: float
    variance_east: float
    covariance_ne: float
    lower: float
    """The mean height less that which north and east are told for,"""
    variance: float
    """and its variance;"""
    square: float
    """of its square the mean"""
    square_variance: float
    """and the variance."""
    by_height: tuple[float, float]
    """Derivatives at the mean height,"""
    bend: tuple[float, float]
    by_attitude: tuple[float, float]
    azimuth: tuple[float, float]
    """As in `PositionMeasurement`."""


class Gain(NamedTuple):
    """Of a filter: by how much its four states follow an innovation."""

    north: Four
    east: Four


class Innovation(NamedTuple):
    """How a measurement differs from what a hypothesis expects, at its mean height."""

    north: float
    east: float
    log_likelihood: float
    """Log of the density of the measurement, times 2 pi."""
    step: float
    """What it says of the height: change of the mean,"""
    variance: float
    """and the variance then,"""
    square: float
    """and the same of the height's square."""
    square_variance: float


@inlined
def lowered(table: Floats, h: int, i: int, step: float) -> Four:
    """Return by how much the states change as the mean height does by `step`; the derivatives become those there."""
    return (
        _lowered(table, h, i, 0, step),
        _lowered(table, h, i, 1, step),
        _lowered(table, h, i, 2, step),
        _lowered(table, h, i, 3, step),
    )


@inlined
def _lowered(table: Floats, h: int, i: int, row: int, step: float) -> float:
    slope, bend = table[h, HEIGHT, row, i], table[h, BEND, row, i]
    table[h, HEIGHT, row, i] = slope + 2.0 * bend * step
    moved: float = (slope + bend * step) * step
    return moved


@kernel
def carry_on(table: Floats, h: int, dt: float, climb: float) -> None:
    """Time update of all objects: places change by the velocities. Along the rows, which is how they lie in memory.

    The height is the present one: an object that climbs by `climb`, a standard deviation, m/s, was lower by dt of that.
    """
    for row in range(STATE):
        for i in range(table.shape[3]):
            table[h, CLIMB, row, i] -= dt * climb * table[h, HEIGHT, row, i]
    for c in range(UNSEEN):
        for axis in range(2):
            for i in range(table.shape[3]):
                table[h, c, axis, i] += dt * table[h, c, VELOCITY + axis, i]


@inlined
def fix_of(measured: PositionMeasurement, k: int, heights: Heights, g: int) -> Fix:
    """Return measurement k for an object at rest or moving, g, north and east at its mean height."""
    told, lower = measured.sensitivity, heights.height[g, k] - measured.height[k]
    bend_n, bend_e = told[BEND, 0, k], told[BEND, 1, k]
    return Fix(
        measured.position[0, k] + (told[HEIGHT, 0, k] + bend_n * lower) * lower,
        measured.position[1, k] + (told[HEIGHT, 1, k] + bend_e * lower) * lower,
        measured.variance_north[k],
        measured.variance_east[k],
        measured.covariance_ne[k],
        lower,
        heights.variance[g, k],
        heights.square[g, k],
        heights.square_variance[g, k],
        (told[HEIGHT, 0, k] + 2.0 * bend_n * lower, told[HEIGHT, 1, k] + 2.0 * bend_e * lower),
        (bend_n, bend_e),
        (told[ATTITUDE, 0, k], told[ATTITUDE, 1, k]),
        (measured.azimuth[0, k], measured.azimuth[1, k]),
    )


@inlined
def correct(table: Floats, h: int, i: int, gain: Gain, told: Innovation, fix: Fix) -> None:
    """Correct the derivatives as the filter corrects its states."""
    _follow(table, h, HEIGHT, i, gain, fix.by_height)
    _follow(table, h, BEND, i, gain, fix.bend)
    _follow(table, h, ATTITUDE, i, gain, fix.by_attitude)
    _follow(table, h, CLIMB, i, gain, (0.0, 0.0))
    north = gain.north[0] * told.north + gain.east[0] * told.east
    east = gain.north[1] * told.north + gain.east[1] * told.east
    _turn(table, h, i, north * fix.azimuth[0] + east * fix.azimuth[1])


@inlined
def _follow(table: Floats, h: int, c: int, i: int, gain: Gain, told: tuple[float, float]) -> None:
    north, east = told[0] - table[h, c, 0, i], told[1] - table[h, c, 1, i]
    for row in range(STATE):
        table[h, c, row, i] += gain.north[row] * north + gain.east[row] * east


@inlined
def _turn(table: Floats, h: int, i: int, angle: float) -> None:
    """Turn what is unseen with the line of sight, which turns as the estimate moves across it.

    Of all measurements before, the derivatives there would be others, too: else each correction, which is mostly noise,
    would look like another look at the object, and tell of its height.
    """
    for c in range(UNSEEN):
        north, east = table[h, c, 0, i], table[h, c, 1, i]
        table[h, c, 0, i] = north - angle * east
        table[h, c, 1, i] = east + angle * north


@inlined
def innovation(table: Floats, h: int, i: int, place: Place, fix: Fix) -> Innovation:
    """Compare a measurement with hypothesis h, whose `place` is that at its mean height."""
    north, east = fix.north - place.north, fix.east - place.east
    # The place is the same by both: what is unseen moves the measurement less than the estimate by this.
    by_n, by_e = table[h, HEIGHT, 0, i] - fix.by_height[0], table[h, HEIGHT, 1, i] - fix.by_height[1]
    bend_n, bend_e = table[h, BEND, 0, i] - fix.bend[0], table[h, BEND, 1, i] - fix.bend[1]
    turn_n, turn_e = table[h, ATTITUDE, 0, i] - fix.by_attitude[0], table[h, ATTITUDE, 1, i] - fix.by_attitude[1]
    climb_n, climb_e = table[h, CLIMB, 0, i], table[h, CLIMB, 1, i]
    spread, bent = fix.variance, fix.square_variance
    shared_nn = by_n * by_n * spread + bend_n * bend_n * bent + turn_n * turn_n + climb_n * climb_n
    shared_ee = by_e * by_e * spread + bend_e * bend_e * bent + turn_e * turn_e + climb_e * climb_e
    shared_ne = by_n * by_e * spread + bend_n * bend_e * bent + turn_n * turn_e + climb_n * climb_e
    s_nn = place.variance_north + fix.variance_north + shared_nn
    s_ee = place.variance_east + fix.variance_east + shared_ee
    s_ne = place.covariance_ne + fix.covariance_ne + shared_ne
    determinant = s_nn * s_ee - s_ne**2
    new_north, new_east = north - bend_n * fix.square, east - bend_e * fix.square
    whitened_north = (s_ee * new_north - s_ne * new_east) / determinant
    whitened_east = (s_nn * new_east - s_ne * new_north) / determinant
    told = (s_ee * by_n**2 - 2.0 * s_ne * by_n * by_e + s_nn * by_e**2) / determinant
    part = _beyond(fix.variance, told, (climb_n**2 + climb_e**2) / max(by_n**2 + by_e**2, TINY))
    told_bend = (s_ee * bend_n**2 - 2.0 * s_ne * bend_n * bend_e + s_nn * bend_e**2) / determinant
    return Innovation(
        north,
        east,
        -0.5 * (new_north * whitened_north + new_east * whitened_east + math.log(determinant)),
        part * fix.variance * (by_n * whitened_north + by_e * whitened_east),
        fix.variance * (1.0 - part * min(fix.variance * told, 1.0)),
        fix.square + bent * (bend_n * whitened_north + bend_e * whitened_east),
        bent * max(1.0 - bent * told_bend, 0.0),
    )


@inlined
def _beyond(variance: float, told: float, alike: float) -> float:
    """Return the share that counts of what a measurement says of the height, so that it leaves `alike` of `variance`.

    A climb looks like an error of the height of the variance `alike`, the same at each ping: it does not average away.
    `told`: what the measurement would take off the variance, over its square.
    """
    return min(max(variance - alike, 0.0) / max(variance * min(variance * told, 1.0), TINY), 1.0)


@kernel
def possible_square(square: float, variance: float, height_variance: float) -> tuple[float, float]:
    """Return mean and variance of the height's square that the variance of the height allows."""
    return min(max(square, 0.0), MOST_SQUARE * height_variance), min(variance, FOURTH_MOMENT * height_variance**2)


@inlined
def shared(
    table: Floats, h: int, i: int, row: int, squares: tuple[float, float], kinds: int = UNSEEN
) -> tuple[float, float, float]:
    """Return what all pings share of states `row` and `row` + 1: both variances and their covariance.

    squares: mean squares of the height and of its square, m^2 and m^4; `kinds`: the first so many of what is unseen.
    """
    nn, ee, ne = 0.0, 0.0, 0.0
    for c in range(kinds):
        north, east = table[h, c, row, i], table[h, c, row + 1, i]
        spread = squares[c] if c < ATTITUDE else 1.0
        nn += spread * north * north
        ee += spread * east * east
        ne += spread * north * east
    return nn, ee, ne
