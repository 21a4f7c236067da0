"""The part in which observers differ: the filters of north and east of all objects, static and moving."""

from typing import Any, NamedTuple, Protocol

from ods.base.arrays import Floats, Indices
from ods.tracker.measurement.model import PositionMeasurement
from ods.tracker.named import Named, TrackTable

RESTING, MOVING = range(2)
"""The first hypothesis; those after it are kinds of motion, of which some observers know one."""
STATE = 4
"""Rows of a state: north, east and their velocities."""
VELOCITY = 2
"""First of the rows of the velocities."""


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
    """(h, UNSEEN, STATE, n) derivatives of the states by what is not seen (`sensitivity.h`)."""


class KindsOfMotion(Protocol):
    """What a filter that follows moving objects by several kinds of motion knows besides."""

    noise: Floats
    """(h - 1,) spectral density of the acceleration of each kind, m^2/s^3."""

    def steady(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects that keep it, the first kind."""


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


class Heights(NamedTuple):
    """What an echo's place in the fan says of the heights of the k objects seen: (2, k), static and moving."""

    height: Floats
    variance: Floats
    square: Floats
    """What was learned of the square of the height, about that mean: its mean, m^2,"""
    square_variance: Floats
    """and its variance, m^4."""
    step: Floats
    """By which the height changed."""


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


class HorizontalFilter(Protocol):
    """Filters for north and east of all objects, static and moving. `rows` are indices of objects."""

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""

    def state(self) -> HorizontalState:
        """Return where objects are; the arrays may be views that the next change spoils."""

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""

    def start(self, new: NewPlaces) -> None:
        """Fill in the last k objects, whose numbers are all 0: their velocity is unknown."""

    def update(
        self, rows: Indices, measured: PositionMeasurement, since_s: Floats, heights: Named[Heights]
    ) -> Named[Learned]:
        """Take one measurement an object; `since_s`: (k,) time since its last one."""

    def rest_there(self, rows: Indices) -> None:
        """Restart the static hypothesis where the moving one is now."""

    def set_out(self, rows: Indices) -> None:
        """Restart the moving hypothesis where the static one is, with unknown velocity."""

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let the static hypotheses of `heirs` learn where those of `old`, the same objects, were."""

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects: they are appended, and removed, there."""
