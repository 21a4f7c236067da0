"""Kalman filters for north and east together, their covariances kept in factors, event driven.

A state is north, east and their velocities; its covariance P = L D L', L unit lower triangular, D diagonal and never
negative. Positions come first, so that what is known of them alone is the upper left corner of the factors. Every
change is a sum of squares with weights that are not negative: P stays symmetric and positive definite whatever the
noise ratios and intervals. Measurement update: Bierman's; all else: C. L. Thornton's weighted Gram-Schmidt
orthogonalization (G. J. Bierman, Factorization Methods for Discrete Sequential Estimation, 1977).

All functions are of column `i` of a (FACTORS, n) table `s`, in place; observers call them in compiled loops.
"""

import math

from ods.base.arrays import Floats
from ods.base.kernel import kernel

NORTH, EAST, VELOCITY = 0, 1, 2
"""Rows of the state; two of VELOCITY."""
DIAGONAL = 4
"""First of the four rows of D."""
LOWER = 8
"""First of the six rows of L below its diagonal: (1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)."""
FACTORS = 14
PROCESS_COLUMNS = 8
"""Columns of `work` that `predict` needs."""

LEAST_SHARE = 1e-14
"""Of a coordinate's variance at least this share is independent of the other's: rounding must not make it negative."""


@kernel
def start(s: Floats, i: int, north: float, east: float, mixed: float, velocity_variance: float) -> None:
    """Set the covariance: variances and covariance of the position; the velocity is not correlated with it."""
    s[DIAGONAL : LOWER + 6, i] = 0.0
    s[LOWER, i] = mixed / north
    s[DIAGONAL, i] = north
    s[DIAGONAL + 1, i] = max(east - mixed**2 / north, LEAST_SHARE * east)
    s[DIAGONAL + 2, i] = s[DIAGONAL + 3, i] = velocity_variance


@kernel
def place_covariance(s: Floats, i: int) -> tuple[float, float, float]:
    """Return the variances of north and east and their covariance."""
    north, slope = s[DIAGONAL, i], s[LOWER, i]
    return north, s[DIAGONAL + 1, i] + slope**2 * north, slope * north


@kernel
def velocity_variances(s: Floats, i: int) -> tuple[float, float]:
    """Return the variances of both velocities."""
    d0, d1, d2, d3 = s[DIAGONAL, i], s[DIAGONAL + 1, i], s[DIAGONAL + 2, i], s[DIAGONAL + 3, i]
    north = s[LOWER + 1, i] ** 2 * d0 + s[LOWER + 2, i] ** 2 * d1 + d2
    east = s[LOWER + 3, i] ** 2 * d0 + s[LOWER + 4, i] ** 2 * d1 + s[LOWER + 5, i] ** 2 * d2 + d3
    return north, east


@kernel
def drift(s: Floats, i: int, variance: float) -> None:
    """Time update of what has no velocity: both coordinates become uncertain by `variance` >= 0."""
    if variance == 0.0:
        return
    north, slope = s[DIAGONAL, i], s[LOWER, i]
    larger = north + variance
    s[DIAGONAL, i] = larger
    s[DIAGONAL + 1, i] += variance + slope**2 * north * (variance / larger)
    s[LOWER, i] = slope * (north / larger)


@kernel
def predict(s: Floats, i: int, dt: float, noise: float, work: Floats, weight: Floats) -> None:
    """Time update over `dt` >= 0 seconds with white acceleration of spectral density `noise`, m^2/s^3, along each axis.

    Two steps equal one long one. `work`, `weight`: scratch, (4, PROCESS_COLUMNS) and (PROCESS_COLUMNS,).
    """
    if dt == 0.0:
        return
    columns(s, i, work, weight, 0, 1.0)
    for axis in range(2):
        s[axis, i] += dt * s[VELOCITY + axis, i]
        for column in range(4):
            work[axis, column] += dt * work[VELOCITY + axis, column]
        # An axis' process noise in factors: [[dt^3/3, dt^2/2], [dt^2/2, dt]].
        work[:, 4 + axis], work[:, 6 + axis] = 0.0, 0.0
        work[axis, 4 + axis], work[VELOCITY + axis, 4 + axis] = dt, 1.5
        work[VELOCITY + axis, 6 + axis] = 1.0
        weight[4 + axis], weight[6 + axis] = noise * dt / 3.0, noise * dt / 4.0
    triangular(s, i, work, weight, PROCESS_COLUMNS)


@kernel
def update(s: Floats, i: int, place: Floats, k: int, north: float, east: float, mixed: float) -> float:
    """Measurement update with column k of `place` (2 or more, m), its variances (> 0) and covariance.

    Returns the log of the probability density of that place beforehand, times 2 pi.
    """
    slope = mixed / north
    left = max(east - slope * mixed, LEAST_SHARE * east)
    density: float = _scalar(s, i, 1.0, 0.0, place[0, k] - s[NORTH, i], north)
    # Of east only that part is new which north does not say already: its noise is independent.
    innovation = place[1, k] - s[EAST, i] - slope * (place[0, k] - s[NORTH, i])
    density += _scalar(s, i, s[LOWER, i] - slope, 1.0, innovation, left)
    return density


@kernel
def _scalar(s: Floats, i: int, f0: float, f1: float, innovation: float, noise: float) -> float:
    """Take one number in, that is h' x with noise; f0, f1: L' h, which has no other entries.

    Returns the log of its probability density beforehand, times sqrt(2 pi).
    """
    v0, v1 = s[DIAGONAL, i] * f0, s[DIAGONAL + 1, i] * f1
    without = noise + f1 * v1
    whole = without + f0 * v0
    s[DIAGONAL, i] *= without / whole
    s[DIAGONAL + 1, i] *= noise / without
    step = innovation / whole
    s[NORTH, i] += v0 * step
    for row in range(1, 4):
        at = LOWER + row * (row - 1) // 2
        by_east = v1 if row == 1 else v1 * s[at + 1, i]
        by_north = v0 * s[at, i]
        s[at, i] -= f0 / without * by_east
        s[row, i] += (by_east + by_north) * step
    density: float = -0.5 * (innovation * step + math.log(whole))
    return density


@kernel
def columns(s: Floats, i: int, work: Floats, weight: Floats, first: int, share: float) -> None:
    """Write L and `share` x D to four columns of `work` and `weight` from `first` on."""
    for column in range(4):
        weight[first + column] = share * s[DIAGONAL + column, i]
        for row in range(4):
            if row > column:
                work[row, first + column] = s[LOWER + row * (row - 1) // 2 + column, i]
            else:
                work[row, first + column] = 1.0 if row == column else 0.0


@kernel
def triangular(s: Floats, i: int, work: Floats, weight: Floats, count: int) -> None:
    """Find the factors of the sum of weight[c] work[:, c] work[:, c]' over the first `count` columns; spoils `work`."""
    for row in range(4):
        square = 0.0
        for c in range(count):
            square += weight[c] * work[row, c] ** 2
        s[DIAGONAL + row, i] = square
        for below in range(row + 1, 4):
            product = 0.0
            for c in range(count):
                product += weight[c] * work[row, c] * work[below, c]
            slope = product / square if square > 0.0 else 0.0
            s[LOWER + below * (below - 1) // 2 + row, i] = slope
            for c in range(count):
                work[below, c] -= slope * work[row, c]
