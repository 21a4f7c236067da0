"""The paper's observer: independent Kalman filters for north and east, in closed form (`axis_kalman`) [SSIE eq. 2].

The gains of each axis know nothing of the other one. The noise of range and bearing goes together in both, and so do
the errors of what is estimated: their covariance under these gains is kept beside the filters, to tell how large errors
are.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled.kernel import kernel
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTable, each
from ods.tracker.observer import axis_kalman, sensitivity
from ods.tracker.observer.axis_kalman import AxisState
from ods.tracker.observer.horizontal import RESTING, HorizontalState, Learned, NewPlaces, learned_rows
from ods.tracker.observer.sensitivity import (
    STATE,
    VELOCITY,
    Fix,
    Four,
    Gain,
    Heights,
    Innovation,
    Place,
)
from ods.tracker.settings import MotionSettings


class IndependentState(NamedTuple):
    """Filters of n objects: (2, n) each, north and east."""

    place: Floats
    """Position if the object does not move;"""
    position: Floats
    """if it moves;"""
    place_variance: Floats
    variance: Floats
    """of both;"""
    velocity: Floats
    """if it moves, and the other factors of its covariance (see `axis_kalman`):"""
    slope: Floats
    residual: Floats


class Together(NamedTuple):
    """Covariances of north and east of n objects: (n,) each."""

    place: Floats
    """Of both if the object does not move;"""
    position: Floats
    """if it moves:"""
    north_velocity: Floats
    """of the velocity north and the place east,"""
    east_velocity: Floats
    """of the place north and the velocity east,"""
    velocity: Floats
    """and of both velocities."""


MOVING = 1
MOST_ALIKE = 1.0 - 1e-9
"""Largest correlation of two errors that is kept."""
POSITIONS, VARIANCES = slice(0, 2), slice(2, 4)
"""The fields above for both hypotheses, RESTING and MOVING."""
PLACE, SPREAD, SPEED, SLOPE, RESIDUAL = 0, 2, 4, 5, 6
"""Rows of `IndependentState`; of PLACE and SPREAD, the variance, that of hypothesis h is h further. By number, as what
is called for each object would take longer to name all rows than to do its work."""
NORTH_SPEED, EAST_SPEED, SPEEDS = 2, 3, 4
"""Rows of `Together`, of which the first two are of the places by both hypotheses."""


_Tables = tuple[Floats, Floats, Floats]
"""Filters, covariances of both axes, derivatives."""


@kernel
def _together_rows(table: Floats) -> Together:
    return Together(table[0], table[1], table[2], table[3], table[4])


@kernel
def _rows(table: Floats) -> IndependentState:
    return IndependentState(table[0], table[1], table[2], table[3], table[4], table[5], table[6])


class IndependentAxes:
    """See `ods.tracker.observer.horizontal.HorizontalFilter`."""

    def __init__(self, settings: MotionSettings) -> None:
        self._settings = settings
        self._table = TrackTable(IndependentState, (len(IndependentState._fields), 2))
        self._together = TrackTable(Together, (len(Together._fields),))
        self._unseen = TrackTable(each, (2, UNSEEN, STATE))

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        motion = self._settings
        tables = self._table.table, self._together.table, self._unseen.table
        _predict(tables, dt, (motion.acceleration_noise, motion.static_noise, motion.vertical_velocity_sigma))

    def state(self) -> HorizontalState:
        """Return where objects are; the arrays are views."""
        s, n = self._table.table, len(self._table)
        return HorizontalState(
            np.ones((1, n)), s[POSITIONS], s[VARIANCES], self._together.table[:2], self._unseen.table
        )

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""
        return self._table.rows.velocity, _velocity_variance(self._table.table)

    def append(self, new: NewPlaces) -> None:
        """Append objects whose velocity is unknown."""
        count = len(new.covariance_ne)
        rows = self._table.grow(count)
        rows.place[:] = rows.position[:] = new.position
        rows.place_variance[:] = rows.variance[:] = new.variance
        rows.residual[:] = self._settings.velocity_sigma**2
        together, first = self._together.grow(count), len(self._unseen)
        together.place[:] = together.position[:] = new.covariance_ne
        self._unseen.grow(count)
        self._unseen.table[:, :, :VELOCITY, first:] = new.sensitivity

    def update(
        self, rows: Indices, measured: PositionMeasurement, since_s: Floats, heights: Named[Heights]
    ) -> Named[Learned]:
        """Take one measurement an object; `since_s` is not needed."""
        tables = self._table.table, self._together.table, self._unseen.table
        return Named(Learned, _update(tables, rows, measured, heights.table))

    def rest_there(self, rows: Indices) -> None:
        """Start the static hypothesis anew where the moving one is now."""
        s = self._table.rows
        s.place[:, rows], s.place_variance[:, rows] = s.position[:, rows], s.variance[:, rows]
        together, unseen = self._together.rows, self._unseen.table
        together.place[rows] = together.position[rows]
        unseen[RESTING][:, :VELOCITY, rows] = unseen[MOVING][:, :VELOCITY, rows]

    def set_out(self, rows: Indices) -> None:
        """Start the moving hypothesis anew where the static one is, with unknown velocity."""
        s = self._table.rows
        s.position[:, rows], s.variance[:, rows] = s.place[:, rows], s.place_variance[:, rows]
        together = self._together.rows
        together.position[rows] = together.place[rows]
        together.north_velocity[rows] = together.east_velocity[rows] = together.velocity[rows] = 0.0
        self._unseen.table[MOVING][:, :, rows] = self._unseen.table[RESTING][:, :, rows]
        s.velocity[:, rows] = s.slope[:, rows] = 0.0
        s.residual[:, rows] = self._settings.velocity_sigma**2

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let the static hypotheses of `heirs` learn where those of `old`, the same objects, were."""
        _join((self._table.table, self._together.table, self._unseen.table), heirs, old)

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        for table in self.tables():
            table.keep(mask)

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects."""
        return [self._table, self._together, self._unseen]


@kernel
def _predict(tables: _Tables, dt: float, motion: tuple[float, float, float]) -> None:
    """Carry all filters on; `motion`: noise of the acceleration, noise at rest, standard deviation of a climb."""
    table, together, unseen = tables
    acceleration_noise, static_noise, climb = motion
    s, c = _rows(table), _together_rows(together)
    for i in range(table.shape[2]):
        for axis in range(2):
            moved = axis_kalman.predict(_moving(table, axis, i), dt, acceleration_noise)
            s.position[axis, i], s.variance[axis, i] = moved.position, moved.variance
            s.slope[axis, i], s.residual[axis, i] = moved.slope, moved.residual
            s.place_variance[axis, i] += static_noise * dt
        c.position[i] += dt * (c.north_velocity[i] + c.east_velocity[i] + dt * c.velocity[i])
        c.north_velocity[i] += dt * c.velocity[i]
        c.east_velocity[i] += dt * c.velocity[i]
        c.position[i] = _possible(c.position[i], s.variance[0, i], s.variance[1, i])
    sensitivity.carry_on(unseen, MOVING, dt, climb)


@kernel
def _moving(table: Floats, axis: int, i: int) -> AxisState:
    """Return one axis of object i if it moves."""
    return AxisState(
        table[PLACE + MOVING, axis, i],
        table[SPEED, axis, i],
        table[SPREAD + MOVING, axis, i],
        table[SLOPE, axis, i],
        table[RESIDUAL, axis, i],
    )


@kernel
def _velocity_variance(table: Floats) -> Floats:
    s, found = _rows(table), np.empty(table.shape[1:])
    for axis in range(2):
        for i in range(table.shape[2]):
            found[axis, i] = axis_kalman.velocity_variance(s.variance[axis, i], s.slope[axis, i], s.residual[axis, i])
    return found


@kernel
def _update(tables: _Tables, rows: Indices, measured: PositionMeasurement, height_table: Floats) -> Floats:
    """Update all filters of `rows`, in place; return the (5, 2, k) table of `Learned`."""
    table, together, unseen = tables
    heights, found = sensitivity.height_rows(height_table), np.empty((5, 2, len(rows)))
    learned = learned_rows(found)
    for k, i in enumerate(rows):
        for h in range(2):
            _shift(table, h, i, sensitivity.lowered(unseen, h, i, heights.step[h, k]))
            fix = sensitivity.fix_of(measured, k, heights, h)
            told = sensitivity.innovation(unseen, h, i, _place(table, together, h, i), fix)
            gain = _correct(table, h, i, told, fix)
            _correct_together(table, together, h, i, gain, fix.covariance_ne)
            sensitivity.correct(unseen, h, i, gain, told, fix)
            learned.log_likelihood[h, k], learned.step[h, k] = told.log_likelihood, told.step
            learned.variance[h, k], learned.square[h, k] = told.variance, told.square
            learned.square_variance[h, k] = told.square_variance
            _shift(table, h, i, sensitivity.lowered(unseen, h, i, told.step))
    return found


@kernel
def _shift(table: Floats, h: int, i: int, by: Four) -> None:
    """Change the states of a hypothesis."""
    for axis in range(2):
        table[PLACE + h, axis, i] += by[axis]
        if h == MOVING:
            table[SPEED, axis, i] += by[VELOCITY + axis]


@kernel
def _place(table: Floats, together: Floats, h: int, i: int) -> Place:
    """Return where an object is by a hypothesis."""
    return Place(
        table[PLACE + h, 0, i],
        table[PLACE + h, 1, i],
        table[SPREAD + h, 0, i],
        table[SPREAD + h, 1, i],
        together[PLACE + h, i],
    )


@kernel
def _correct(table: Floats, h: int, i: int, told: Innovation, fix: Fix) -> Gain:
    """Correct a hypothesis by the innovation; return how its states followed."""
    north = _correct_axis(table, h, 0, i, told.north, fix.variance_north)
    east = _correct_axis(table, h, 1, i, told.east, fix.variance_east)
    return Gain((north[0], 0.0, north[1], 0.0), (0.0, east[0], 0.0, east[1]))


@kernel
def _correct_together(table: Floats, c: Floats, h: int, i: int, gain: Gain, noise: float) -> None:
    """Correct the covariances `c` of a hypothesis whose filters were corrected; `noise`: that of the measurement."""
    n, e, nv, ev = gain.north[0], gain.east[1], gain.north[2], gain.east[3]
    both = c[PLACE + h, i]
    left = (1.0 - n) * (1.0 - e) * both + n * e * noise
    c[PLACE + h, i] = _possible(left, table[SPREAD + h, 0, i], table[SPREAD + h, 1, i])
    if h == MOVING:
        c[SPEEDS, i] += nv * ev * (both + noise) - nv * c[EAST_SPEED, i] - ev * c[NORTH_SPEED, i]
        c[NORTH_SPEED, i] = (1.0 - e) * (c[NORTH_SPEED, i] - nv * both) + nv * e * noise
        c[EAST_SPEED, i] = (1.0 - n) * (c[EAST_SPEED, i] - ev * both) + n * ev * noise


@kernel
def _possible(covariance: float, north: float, east: float) -> float:
    """Return a covariance that rounding did not make larger than the variances allow."""
    most = MOST_ALIKE * math.sqrt(north * east)
    return min(max(covariance, -most), most)


@kernel
def _correct_axis(table: Floats, h: int, axis: int, i: int, step: float, noise: float) -> tuple[float, float]:
    """Correct one axis; return by how much position and velocity follow."""
    if h == RESTING:
        place = table[PLACE, axis, i]
        table[PLACE, axis, i], table[SPREAD, axis, i] = axis_kalman.update_constant(
            place, table[SPREAD, axis, i], place + step, noise
        )
        return table[SPREAD, axis, i] / noise, 0.0
    before = _moving(table, axis, i)
    moved = axis_kalman.update(before, before.position + step, noise)
    table[PLACE + MOVING, axis, i], table[SPEED, axis, i] = moved.position, moved.velocity
    table[SPREAD + MOVING, axis, i] = moved.variance
    return moved.variance / noise, moved.slope * (moved.variance / noise)


@kernel
def _join(tables: _Tables, heirs: Indices, old: Indices) -> None:
    table, together, unseen = tables
    s, both = _rows(table), _together_rows(together).place
    for heir, before in zip(heirs, old):  # noqa: B905  numba knows no `strict`
        left, added = both[heir], both[before]
        for axis in range(2):
            noise = s.place_variance[axis, before]
            s.place[axis, heir], s.place_variance[axis, heir] = axis_kalman.update_constant(
                s.place[axis, heir], s.place_variance[axis, heir], s.place[axis, before], noise
            )
            gain = s.place_variance[axis, heir] / noise
            left, added = left * (1.0 - gain), added * gain
            for c in range(UNSEEN):
                own = unseen[RESTING, c, axis]
                own[heir] += gain * (own[before] - own[heir])
        both[heir] = _possible(left + added, s.place_variance[0, heir], s.place_variance[1, heir])
