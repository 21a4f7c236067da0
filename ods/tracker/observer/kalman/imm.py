"""North and east in one filter, so that the noise of range and bearing keeps its shape; one or more kinds of motion.

Moving objects may be followed by several filters that differ in how much the velocity changes, each with its share of
belief: interacting multiple models (H. A. P. Blom, Y. Bar-Shalom, IEEE Trans. Automatic Control 33, 1988). The models
exchange their states once a second, as much as the time since the last exchange lets an object change its ways.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.compiled import native
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTable, each
from ods.tracker.observer.horizontal import STATE, Heights, HorizontalState, Learned, NewPlaces
from ods.tracker.settings import MotionSettings

FACTORS = STATE + 10
"""Rows of a filter: its state, then the factors of its covariance (`ud_filter.h`)."""


class Model(NamedTuple):
    """A way in which objects move."""

    noise: float
    """Spectral density of the acceleration, m^2/s^3."""
    share: float
    """How often, of all the time, an object moves so."""


class InteractingModels:
    """See `ods.tracker.observer.horizontal.HorizontalFilter`."""

    def __init__(self, settings: MotionSettings, models: Sequence[Model], change_rate: float = 0.0) -> None:
        """Follow moving objects by `models`, between which they change `change_rate` times a second."""
        self._settings = settings
        self.noise = np.array([model.noise for model in models])
        """See `KindsOfMotion`."""
        self._usual = np.array([model.share for model in models])
        self._change_rate = change_rate
        self._filters = TrackTable(each, (1 + len(models), FACTORS))
        self._share = TrackTable(each, (len(models),))
        self._unseen = TrackTable(each, (1 + len(models), UNSEEN, STATE))
        self._apart = TrackTable(each, (1,))
        """Time since the models exchanged their states, s."""

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        motion = self._settings
        filters, unseen = self._filters.table, self._unseen.table
        native.imm_predict(filters, unseen, dt, motion.static_noise, self.noise, motion.vertical_velocity_sigma)

    def state(self) -> HorizontalState:
        """Return where objects are."""
        filters = self._filters.table
        hypotheses, _, n = filters.shape
        position, variance = np.empty((hypotheses, 2, n)), np.empty((hypotheses, 2, n))
        covariance_ne = np.empty((hypotheses, n))
        native.imm_places(filters, position, variance, covariance_ne)
        return HorizontalState(self._share.table, position, variance, covariance_ne, self._unseen.table)

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""
        return _velocity(self._filters.table, self._share.table)

    def steady(self) -> tuple[Floats, Floats]:
        """See `KindsOfMotion`."""
        return _velocity(self._filters.table[:2], np.ones((1, len(self._filters))))

    def start(self, new: NewPlaces) -> None:
        """Fill in the last objects, whose velocity is unknown."""
        native.imm_start(self._numbers(), new, self._usual, self._settings.velocity_sigma**2)

    def update(
        self, rows: Indices, measured: PositionMeasurement, since_s: Floats, heights: Named[Heights]
    ) -> Named[Learned]:
        """Take one measurement an object, `since_s` after its last one."""
        learned = np.empty((len(Learned._fields), 2, len(rows)))
        habits = self._usual, self._change_rate
        native.imm_update(self._numbers(), rows, measured, since_s, habits, heights.table, learned)
        return Named(Learned, learned)

    def rest_there(self, rows: Indices) -> None:
        """Restart the static hypothesis where the likeliest of the moving ones is now."""
        native.imm_rest_there(self._numbers(), rows)

    def set_out(self, rows: Indices) -> None:
        """Restart the moving hypotheses where the static one is, with unknown velocity."""
        native.imm_set_out(self._numbers(), rows, self._usual, self._settings.velocity_sigma**2)

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let the static hypotheses of `heirs` learn where those of `old`, the same objects, were."""
        native.imm_join(self._numbers(), heirs, old)

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects."""
        return [self._filters, self._share, self._unseen, self._apart]

    def _numbers(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return the numbers of all tables."""
        return self._filters.table, self._share.table, self._unseen.table, self._apart.table[0]


def _velocity(filters: Floats, share: Floats) -> tuple[Floats, Floats]:
    """Return mean and variance (2, n) of the moving hypotheses of `filters` taken together."""
    moments = np.empty((2, 2, share.shape[1]))
    native.imm_velocity(filters, share, moments)
    mean, variance = moments
    return mean, variance
