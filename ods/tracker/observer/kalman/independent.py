"""The paper's observer: independent Kalman filters for north and east, in closed form (`axis_kalman`) [SSIE eq. 2].

The gains of each axis know nothing of the other one. The noise of range and bearing goes together in both, and so do
the errors of what is estimated: their covariance under these gains is kept beside the filters, to show how large errors
are.
"""

from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.compiled import native
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTable, each
from ods.tracker.observer.horizontal import (
    MOVING,
    RESTING,
    STATE,
    VELOCITY,
    Heights,
    HorizontalState,
    Learned,
    NewPlaces,
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


class CrossCovariances(NamedTuple):
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


class IndependentAxes:
    """See `ods.tracker.observer.horizontal.HorizontalFilter`."""

    def __init__(self, settings: MotionSettings) -> None:
        self._settings = settings
        self._table = TrackTable(IndependentState, (len(IndependentState._fields), 2))
        self._together = TrackTable(CrossCovariances, (len(CrossCovariances._fields),))
        self._unseen = TrackTable(each, (2, UNSEEN, STATE))

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        motion = self._settings
        noise = motion.acceleration_noise, motion.static_noise, motion.vertical_velocity_sigma
        native.independent_predict(self._numbers(), dt, noise)

    def state(self) -> HorizontalState:
        """Return where objects are; the arrays are views: tables begin with the fields of both hypotheses."""
        s, n = self._table.table, len(self._table)
        return HorizontalState(np.ones((1, n)), s[:2], s[2:4], self._together.table[:2], self._unseen.table)

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""
        s = self._table.rows
        return s.velocity, s.residual + s.slope**2 * s.variance

    def start(self, new: NewPlaces) -> None:
        """Fill in the last objects, whose velocity is unknown."""
        count = len(new.covariance_ne)
        rows, together = self._table.last(count), self._together.last(count)
        rows.place[:] = rows.position[:] = new.position
        rows.place_variance[:] = rows.variance[:] = new.variance
        rows.residual[:] = self._settings.velocity_sigma**2
        together.place[:] = together.position[:] = new.covariance_ne
        self._unseen.table[:, :, :VELOCITY, len(self._unseen) - count :] = new.sensitivity

    def update(
        self, rows: Indices, measured: PositionMeasurement, since_s: Floats, heights: Named[Heights]
    ) -> Named[Learned]:
        """Take one measurement an object; `since_s` is not needed."""
        learned = np.empty((len(Learned._fields), 2, len(rows)))
        native.independent_update(self._numbers(), rows, measured, heights.table, learned)
        return Named(Learned, learned)

    def rest_there(self, rows: Indices) -> None:
        """Restart the static hypothesis where the moving one is now."""
        s = self._table.rows
        s.place[:, rows], s.place_variance[:, rows] = s.position[:, rows], s.variance[:, rows]
        together, unseen = self._together.rows, self._unseen.table
        together.place[rows] = together.position[rows]
        unseen[RESTING][:, :VELOCITY, rows] = unseen[MOVING][:, :VELOCITY, rows]

    def set_out(self, rows: Indices) -> None:
        """Restart the moving hypothesis where the static one is, with unknown velocity."""
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
        native.independent_join(self._numbers(), heirs, old)

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects."""
        return [self._table, self._together, self._unseen]

    def _numbers(self) -> tuple[Floats, Floats, Floats]:
        """Return the numbers of all tables."""
        return self._table.table, self._together.table, self._unseen.table
