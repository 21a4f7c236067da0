"""An observer of your own: north and east filtered apart, in plain numpy, constant velocity if the object moves."""

from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTable
from ods.tracker.observer.horizontal import STATE, Heights, HorizontalState, Learned, NewPlaces
from ods.tracker.observer.motion_hypotheses import StaticOrMovingObserver
from ods.tracker.observer.registry import observer
from ods.tracker.settings import MotionSettings


@observer("plain")
def plain(settings: MotionSettings) -> StaticOrMovingObserver:
    """Called once. What asks whether objects move at all, and filters height and radius, is there already."""
    return StaticOrMovingObserver(settings, PlainAxes(settings))


class PlainState(NamedTuple):
    """What is known of n objects: (2, n) each, north and east."""

    place: Floats
    """Position if the object does not move,"""
    place_variance: Floats
    """and its variance;"""
    position: Floats
    """if it moves,"""
    velocity: Floats
    variance: Floats
    """and the three of their covariance."""
    covariance: Floats
    velocity_variance: Floats


class PlainAxes:
    """A `HorizontalFilter`. A table with an object a column, so that a tracker that was killed can go on with it."""

    def __init__(self, settings: MotionSettings) -> None:
        self._settings = settings
        self._table = TrackTable(PlainState, (len(PlainState._fields), 2))

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects."""
        return [self._table]

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` seconds."""
        s, noise = self._table.rows, self._settings.acceleration_noise
        s.position[:] += dt * s.velocity
        s.variance[:] += dt * (2.0 * s.covariance + dt * s.velocity_variance) + noise * dt**3 / 3.0
        s.covariance[:] += dt * s.velocity_variance + noise * dt**2 / 2.0
        s.velocity_variance[:] += noise * dt
        s.place_variance[:] += self._settings.static_noise * dt

    def state(self) -> HorizontalState:
        """Return where objects are: at rest first, then moving, of which there is one kind.

        That all depends on heights, too, is left aside: no derivatives.
        """
        s, n = self._table.rows, len(self._table)
        position, variance = np.stack([s.place, s.position]), np.stack([s.place_variance, s.variance])
        unseen = np.zeros((2, UNSEEN, STATE, n))
        return HorizontalState(np.ones((1, n)), position, variance, np.zeros((2, n)), unseen)

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance if objects move."""
        return self._table.rows.velocity, self._table.rows.velocity_variance

    def start(self, new: NewPlaces) -> None:
        """Fill in the last objects, of these places and variances; the velocity is unknown."""
        s = self._table.last(new.position.shape[1])
        s.place[:] = s.position[:] = new.position
        s.place_variance[:] = s.variance[:] = new.variance
        s.velocity_variance[:] = self._settings.velocity_sigma**2

    def update(
        self, rows: Indices, measured: PositionMeasurement, since_s: Floats, heights: Named[Heights]
    ) -> Named[Learned]:
        """Take one measurement a row; return the logs of its likelihoods if the object rests and if it moves."""
        s, seen = self._table.rows, measured.position[:2]
        noise = np.stack([measured.variance_north, measured.variance_east])
        at_rest, if_moving = s.place_variance[:, rows] + noise, s.variance[:, rows] + noise
        off_rest, off = seen - s.place[:, rows], seen - s.position[:, rows]
        gain = s.place_variance[:, rows] / at_rest
        s.place[:, rows] += gain * off_rest
        s.place_variance[:, rows] *= 1.0 - gain
        gain, velocity_gain = s.variance[:, rows] / if_moving, s.covariance[:, rows] / if_moving
        s.position[:, rows] += gain * off
        s.velocity[:, rows] += velocity_gain * off
        s.velocity_variance[:, rows] -= velocity_gain * s.covariance[:, rows]
        s.covariance[:, rows] *= 1.0 - gain
        s.variance[:, rows] *= 1.0 - gain
        unlikely = [np.log(at_rest) + off_rest**2 / at_rest, np.log(if_moving) + off**2 / if_moving]
        told = heights.rows
        as_before = np.zeros_like(told.step), told.variance, told.square, told.square_variance
        return Named(Learned, np.array([-0.5 * np.sum(unlikely, axis=1), *as_before]))

    def rest_there(self, rows: Indices) -> None:
        """Let objects rest, if they do, where they are if they move."""
        s = self._table.rows
        s.place[:, rows], s.place_variance[:, rows] = s.position[:, rows], s.variance[:, rows]

    def set_out(self, rows: Indices) -> None:
        """Let objects move, if they do, from where they rest."""
        s = self._table.rows
        s.position[:, rows], s.variance[:, rows] = s.place[:, rows], s.place_variance[:, rows]
        s.velocity[:, rows] = s.covariance[:, rows] = 0.0
        s.velocity_variance[:, rows] = self._settings.velocity_sigma**2

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let each of `heirs` know where it rested before, when it was `old`."""
        s = self._table.rows
        weight = s.place_variance[:, heirs] / (s.place_variance[:, heirs] + s.place_variance[:, old])
        s.place[:, heirs] += weight * (s.place[:, old] - s.place[:, heirs])
        s.place_variance[:, heirs] *= 1.0 - weight
