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
from ods.compiled.kernel import kernel
from ods.tracker.observer.sensitivity import Four, Gain, Place

NORTH, EAST, VELOCITY = 0, 1, 2
"""Rows of the state; two of VELOCITY."""
STATE_ROWS = 4
DIAGONAL, LOWER = STATE_ROWS, 2 * STATE_ROWS
"""First of the rows of D, and of those of L below its diagonal (see `entry`)."""
FACTORS = LOWER + 6
PROCESS_COLUMNS = 8
"""Columns of `Work` that `predict` needs."""

LEAST_SHARE = 1e-14
"""Of a coordinate's variance at least this share is independent of the other's: rounding must not make it negative."""


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


@kernel
def place_of(s: Floats, i: int) -> Place:
    """Return the position with its covariance."""
    north, slope = s[DIAGONAL + NORTH, i], s[entry(EAST, NORTH), i]
    east = s[DIAGONAL + EAST, i] + slope**2 * north
    return Place(s[NORTH, i], s[EAST, i], north, east, slope * north)


@kernel
def velocity_variances(s: Floats, i: int) -> tuple[float, float]:
    """Return the variances of both velocities."""
    return _variance(s, i, VELOCITY), _variance(s, i, VELOCITY + 1)


@kernel
def _variance(s: Floats, i: int, row: int) -> float:
    total: float = s[DIAGONAL + row, i]
    for column in range(row):
        total += s[entry(row, column), i] ** 2 * s[DIAGONAL + column, i]
    return total


@kernel
def drift(s: Floats, i: int, variance: float) -> None:
    """Time update of what has no velocity: both coordinates become uncertain by `variance` >= 0."""
    if variance == 0.0:
        return
    north, slope = s[DIAGONAL + NORTH, i], s[entry(EAST, NORTH), i]
    larger = north + variance
    s[DIAGONAL + NORTH, i] = larger
    s[DIAGONAL + EAST, i] += variance + slope**2 * north * (variance / larger)
    s[entry(EAST, NORTH), i] = slope * (north / larger)


@kernel
def predict(s: Floats, i: int, dt: float, noise: float, work: Work) -> None:
    """Time update over `dt` >= 0 seconds with white acceleration of spectral density `noise`, m^2/s^3, along each axis.

    Two steps equal one long one. `work`: PROCESS_COLUMNS of scratch.
    """
    if dt == 0.0:
        return
    columns(s, i, work, (0, 1), 1.0)
    column, weight = work.column, work.weight
    for axis in range(2):
        s[axis, i] += dt * s[VELOCITY + axis, i]
        for c in range(STATE_ROWS):
            column[axis, c] += dt * column[VELOCITY + axis, c]
        # An axis' process noise in factors: [[dt^3/3, dt^2/2], [dt^2/2, dt]].
        both, rest = STATE_ROWS + axis, STATE_ROWS + 2 + axis
        column[:, both], column[:, rest] = 0.0, 0.0
        column[axis, both], column[VELOCITY + axis, both] = dt, 1.5
        column[VELOCITY + axis, rest] = 1.0
        weight[both], weight[rest] = noise * dt / 3.0, noise * dt / 4.0
    triangular(s, i, work, PROCESS_COLUMNS, 0)


@kernel
def update(s: Floats, i: int, innovation: tuple[float, float], noise: Place) -> Gain:
    """Measurement update with the north and east of a place less those of the state; return how the states followed.

    `noise`: only its variances, > 0, and its covariance count.
    """
    north, east, mixed = noise.variance_north, noise.variance_east, noise.covariance_ne
    slope = mixed / north
    left = max(east - slope * mixed, LEAST_SHARE * east)
    first = _scalar(s, i, (1.0, 0.0), north)
    # Of east only that part is new which north does not say already: its noise is independent.
    second = _scalar(s, i, (s[entry(EAST, NORTH), i] - slope, 1.0), left)
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


@kernel
def _scalar(s: Floats, i: int, f: tuple[float, float], noise: float) -> Four:
    """Take one number in, that is h' x with noise; f: L' h, which has no other entries; return its gain."""
    f0, f1 = f
    v0, v1 = s[DIAGONAL + NORTH, i] * f0, s[DIAGONAL + EAST, i] * f1
    without = noise + f1 * v1
    whole = without + f0 * v0
    s[DIAGONAL + NORTH, i] *= without / whole
    s[DIAGONAL + EAST, i] *= noise / without
    share = f0 / without
    return (
        v0 / whole,
        _follow(s, i, EAST, (v0, v1), share) / whole,
        _follow(s, i, VELOCITY, (v0, v1), share) / whole,
        _follow(s, i, VELOCITY + 1, (v0, v1), share) / whole,
    )


@kernel
def _follow(s: Floats, i: int, row: int, v: tuple[float, float], share: float) -> float:
    """Update a row of L in its first column; return by how much its state follows."""
    at = entry(row, NORTH)
    by_east = v[1] if row == EAST else v[1] * s[at + 1, i]
    by_north: float = v[0] * s[at, i]
    s[at, i] -= share * by_east
    return by_east + by_north


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
