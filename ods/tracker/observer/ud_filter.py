"""Kalman filters for north and east together, their covariances kept in factors, event driven.

A state is north, east and their velocities; its covariance P = L D L', L unit lower triangular, D diagonal and never
negative. Positions come first, so that what is known of them alone is the upper left corner of the factors. Every
change is a sum of squares with weights that are not negative: P stays symmetric and positive definite whatever the
noise ratios and intervals. Measurement update: Bierman's; all else: C. L. Thornton's weighted Gram-Schmidt
orthogonalization (G. J. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977).

All functions are of column `i` of a (FACTORS, n) table `s`, in place; observers call them in compiled loops.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.compiled.kernel import inlined, kernel
from ods.tracker.observer.sensitivity import Four, Gain, Place

NORTH, EAST, VELOCITY = 0, 1, 2
"""Rows of the state; two of VELOCITY."""
STATE_ROWS = 4
DIAGONAL, LOWER = STATE_ROWS, 2 * STATE_ROWS
"""First of the rows of D, and of those of L below its diagonal (see `entry`)."""
FACTORS = LOWER + 6

LEAST_SHARE = 1e-14
"""Of a coordinate's variance at least this share is independent of the other's: rounding must not make it negative."""

Six = tuple[float, float, float, float, float, float]


class Work(NamedTuple):
    """Scratch: a covariance as the sum of weight[c] column[:, c] column[:, c]'."""

    column: Floats
    """(STATE_ROWS, count)."""
    weight: Floats
    """(count,)."""


@kernel
def work_space(count: int) -> Work:
    """Return scratch for `count` columns."""
    return Work(np.empty((STATE_ROWS, count)), np.empty(count))


@kernel
def entry(row: int, column: int) -> int:
    """Return the row of L[row, column], below the diagonal: (1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)."""
    return LOWER + row * (row - 1) // 2 + column


@kernel
def start(s: Floats, i: int, place: Place, velocity_variance: float) -> None:
    """Set state and covariance; the velocity is 0, as uncertain as is said, and not correlated with the position."""
    north, east, mixed = place.variance_north, place.variance_east, place.covariance_ne
    s[:DIAGONAL, i] = 0.0
    s[NORTH, i], s[EAST, i] = place.north, place.east
    s[LOWER:FACTORS, i] = 0.0
    s[entry(EAST, NORTH), i] = mixed / north
    s[DIAGONAL + NORTH, i] = north
    s[DIAGONAL + EAST, i] = max(east - mixed**2 / north, LEAST_SHARE * east)
    s[DIAGONAL + VELOCITY : LOWER, i] = velocity_variance


@inlined
def place_of(s: Floats, i: int) -> Place:
    """Return the position with its covariance."""
    north, slope = s[DIAGONAL + NORTH, i], s[entry(EAST, NORTH), i]
    east = s[DIAGONAL + EAST, i] + slope**2 * north
    return Place(s[NORTH, i], s[EAST, i], north, east, slope * north)


@inlined
def velocity_variances(s: Floats, i: int) -> tuple[float, float]:
    """Return the variances of both velocities."""
    return _variance(s, i, VELOCITY), _variance(s, i, VELOCITY + 1)


@inlined
def _variance(s: Floats, i: int, row: int) -> float:
    total: float = s[DIAGONAL + row, i]
    for column in range(row):
        total += s[entry(row, column), i] ** 2 * s[DIAGONAL + column, i]
    return total


@kernel
def drift(s: Floats, i: int, variance: float) -> None:
    """Time update of what has no velocity: both coordinates become uncertain by `variance` >= 0."""
    factors = s[DIAGONAL + NORTH, i], s[entry(EAST, NORTH), i], s[DIAGONAL + EAST, i]
    s[DIAGONAL + NORTH, i], s[entry(EAST, NORTH), i], s[DIAGONAL + EAST, i] = _enlarged(factors, variance)


@inlined
def _enlarged(factors: tuple[float, float, float], variance: float) -> tuple[float, float, float]:
    """Add `variance` to both of two coordinates; factors: D of the first, L, D of the second."""
    first, slope, second = factors
    if variance == 0.0:
        return factors
    larger = first + variance
    return larger, slope * (first / larger), second + variance + slope**2 * first * (variance / larger)


@kernel
def predict(s: Floats, i: int, dt: float, noise: float) -> None:
    """Time update over `dt` >= 0 seconds with white acceleration of spectral density `noise`, m^2/s^3, along each axis.

    Two steps equal one long one. Along an axis the noise is [[dt^3/3, dt^2/2], [dt^2/2, dt]]: a quarter of dt that the
    velocity gets before the step, and three quarters after it, along (dt/3, 1).
    """
    if dt == 0.0:
        return
    s[NORTH, i] += dt * s[VELOCITY, i]
    s[EAST, i] += dt * s[VELOCITY + 1, i]
    l10, l20, l21 = s[LOWER, i], s[LOWER + 1, i], s[LOWER + 2, i]
    l30, l31, l32 = s[LOWER + 3, i], s[LOWER + 4, i], s[LOWER + 5, i]
    velocities = s[DIAGONAL + VELOCITY, i], l32, s[DIAGONAL + VELOCITY + 1, i]
    d2, l32, d3 = _enlarged(velocities, 0.25 * noise * dt)
    third, later = dt / 3.0, 0.75 * noise * dt
    # Rows of L, moved, then of the noise; in numbers by name, which stay in the processor.
    weight = s[DIAGONAL + NORTH, i], s[DIAGONAL + EAST, i], d2, d3, later, later
    north = 1.0 + dt * l20, dt * l21, dt, 0.0, third, 0.0
    east = l10 + dt * l30, 1.0 + dt * l31, dt * l32, dt, 0.0, third
    v_north = l20, l21, 1.0, 0.0, 1.0, 0.0
    v_east = l30, l31, l32, 1.0, 0.0, 1.0
    s[DIAGONAL, i], one_by = _with_inverse(_product(weight, north, north))
    s[LOWER, i], east = _without(east, north, weight, one_by)
    s[LOWER + 1, i], v_north = _without(v_north, north, weight, one_by)
    s[LOWER + 3, i], v_east = _without(v_east, north, weight, one_by)
    s[DIAGONAL + 1, i], one_by = _with_inverse(_product(weight, east, east))
    s[LOWER + 2, i], v_north = _without(v_north, east, weight, one_by)
    s[LOWER + 4, i], v_east = _without(v_east, east, weight, one_by)
    s[DIAGONAL + 2, i], one_by = _with_inverse(_product(weight, v_north, v_north))
    s[LOWER + 5, i], v_east = _without(v_east, v_north, weight, one_by)
    s[DIAGONAL + 3, i] = _product(weight, v_east, v_east)


@inlined
def _with_inverse(square: float) -> tuple[float, float]:
    """Return a square and one by it; 0 for 0, as nothing leans on what is certain."""
    return square, (1.0 / square if square > 0.0 else 0.0)


@inlined
def _product(w: Six, a: Six, b: Six) -> float:
    return (
        w[0] * a[0] * b[0]
        + w[1] * a[1] * b[1]
        + w[2] * a[2] * b[2]
        + w[3] * a[3] * b[3]
        + w[4] * a[4] * b[4]
        + w[5] * a[5] * b[5]
    )


@inlined
def _without(row: Six, other: Six, weight: Six, one_by: float) -> tuple[float, Six]:
    """Return how much of `other`, of which `one_by` is one by its own product, is in a row; the row without that."""
    share = _product(weight, row, other) * one_by
    return share, (
        row[0] - share * other[0],
        row[1] - share * other[1],
        row[2] - share * other[2],
        row[3] - share * other[3],
        row[4] - share * other[4],
        row[5] - share * other[5],
    )


class Corner(NamedTuple):
    """What a measurement of the position changes of the factors: D of the position, and the first column of L."""

    north: float
    east: float
    of_east: float
    of_v_north: float
    of_v_east: float


@inlined
def update(s: Floats, i: int, innovation: tuple[float, float], noise: Place) -> Gain:
    """Measurement update with the north and east of a place less those of the state; return how the states followed.

    `noise`: only its variances, > 0, and its covariance count.
    """
    north, east, mixed = noise.variance_north, noise.variance_east, noise.covariance_ne
    slope = mixed / north
    left = max(east - slope * mixed, LEAST_SHARE * east)
    corner = Corner(s[DIAGONAL, i], s[DIAGONAL + EAST, i], s[LOWER, i], s[LOWER + 1, i], s[LOWER + 3, i])
    by_east = s[entry(VELOCITY, EAST), i], s[entry(VELOCITY + 1, EAST), i]
    corner, first = _scalar(corner, by_east, (1.0, 0.0), north)
    # Of east only that part is new which north does not say already: its noise is independent.
    corner, second = _scalar(corner, by_east, (corner.of_east - slope, 1.0), left)
    s[DIAGONAL, i], s[DIAGONAL + EAST, i] = corner.north, corner.east
    s[LOWER, i], s[LOWER + 1, i], s[LOWER + 3, i] = corner.of_east, corner.of_v_north, corner.of_v_east
    again = first[EAST] + slope * (1.0 - first[NORTH])
    by_north = (
        first[0] - again * second[0],
        first[1] - again * second[1],
        first[2] - again * second[2],
        first[3] - again * second[3],
    )
    for row in range(STATE_ROWS):
        s[row, i] += by_north[row] * innovation[0] + second[row] * innovation[1]
    return Gain(by_north, second)


@inlined
def _scalar(corner: Corner, by_east: tuple[float, float], f: tuple[float, float], noise: float) -> tuple[Corner, Four]:
    """Take one number in, that is h' x with noise; f: L' h, which has no other entries; return its gain, too.

    by_east: L of the velocities by east, which stays.
    """
    f0, f1 = f
    v0, v1 = corner.north * f0, corner.east * f1
    without = noise + f1 * v1
    whole = without + f0 * v0
    share = f0 / without
    a, b = v1 * by_east[0], v1 * by_east[1]
    _, _, l1, l2, l3 = corner
    gain = v0 / whole, (v1 + v0 * l1) / whole, (a + v0 * l2) / whole, (b + v0 * l3) / whole
    told = corner.north * (without / whole), corner.east * (noise / without)
    return Corner(told[0], told[1], l1 - share * v1, l2 - share * a, l3 - share * b), gain


@kernel
def columns(s: Floats, i: int, work: Work, where: tuple[int, int], share: float) -> None:
    """Write L and `share` x D to four columns of `work`; `where`: the first of them, and from each to the next."""
    first, apart = where
    for column in range(STATE_ROWS):
        to = first + apart * column
        work.weight[to] = share * s[DIAGONAL + column, i]
        for row in range(STATE_ROWS):
            if row > column:
                work.column[row, to] = s[entry(row, column), i]
            else:
                work.column[row, to] = 1.0 if row == column else 0.0


@kernel
def triangular(s: Floats, i: int, work: Work, first: int, more: int) -> None:
    """Find the factors of the sum of columns; spoils `work`.

    Row 0 has entries in the `first` columns, each further row in `more` besides: all else is 0, and left out.
    """
    column, weight = work.column, work.weight
    for row in range(STATE_ROWS):
        square, count = 0.0, first + more * row
        for c in range(count):
            square += weight[c] * column[row, c] ** 2
        s[DIAGONAL + row, i] = square
        for below in range(row + 1, STATE_ROWS):
            product = 0.0
            for c in range(count):
                product += weight[c] * column[row, c] * column[below, c]
            slope = product / square if square > 0.0 else 0.0
            s[entry(below, row), i] = slope
            for c in range(count):
                column[below, c] -= slope * column[row, c]
