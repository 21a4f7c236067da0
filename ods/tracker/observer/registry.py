"""The library of observers: filters for the states of all objects at once, chosen by name [SSIE].

An observer keeps one column an object, in the order in which they were started; `Tracker` keeps its own columns in
step. `OBSERVERS` maps the name in the configuration to a factory that takes the motion settings; a plug-in adds to it:

    @observer("brisk")
    def brisk(settings: MotionSettings) -> Observer:
        return StaticOrMovingObserver(settings, ...)
"""

from collections.abc import Callable
from typing import Any, Protocol

from ods.base.arrays import Floats, Indices
from ods.base.choices import none_of
from ods.base.plugins import PluginError, add
from ods.tracker.measurement.model import PositionMeasurement
from ods.tracker.named import TrackTable
from ods.tracker.observer.belief import Belief
from ods.tracker.observer.kalman.imm import InteractingModels, Model
from ods.tracker.observer.kalman.independent import IndependentAxes
from ods.tracker.observer.motion_hypotheses import StaticOrMovingObserver
from ods.tracker.settings import OBSERVER_NAMES, MotionSettings

AGILE = 10.0
"""Acceleration noise of an object that manoeuvres, in units of `acceleration_noise`, which is as many times that of one
that changes its velocity by and by; that of one that keeps it is `steady_noise`."""
STEADY = 0.8
"""Share of the time that a moving object keeps its velocity; of the rest it manoeuvres half."""
CHANGE_RATE = 0.03
"""How often it changes between these ways, 1/s: each change costs what was known of a steady velocity."""


class Observer(Protocol):
    """Interface of a set of filters. `rows` are indices of objects."""

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""

    def belief(self) -> Belief:
        """Return the hypotheses of all objects; the arrays may be views that the next change spoils."""

    def static(self) -> Floats:
        """Return (n,) the probability that each object does not move: that of `belief`, which is more work."""

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (3, n) of all velocities."""

    def start(self, measured: PositionMeasurement) -> None:
        """Append new objects, one a measurement."""

    def recall(
        self, position: Floats, variance: Floats, covariance_ne: Floats, radius: Floats, radius_variance: Floats
    ) -> None:
        """Append objects from the map, known not to move: (3, k), (3, k), (k,), (k,), (k,)."""

    def update(self, rows: Indices, measured: PositionMeasurement, since_s: Floats) -> None:
        """Take one measurement an object, `since_s` after its last one."""

    def settle(self, rows: Indices) -> None:
        """Decide for good whether each object moves, where that is established: the static ones stay where they are."""

    def rest(self, rows: Indices) -> None:
        """Decide for good that objects do not move: they are where they were when seen."""

    def reopen(self, rows: Indices) -> None:
        """Take the decision of `settle` back: the object is seen again."""

    def inherit(self, heirs: Indices, old: Indices) -> None:
        """Let `heirs` inherit what is settled of `old`: they are the same objects, seen again."""

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects: objects that end are removed from there; a successor gets it."""


def _independent(settings: MotionSettings) -> Observer:
    return StaticOrMovingObserver(settings, IndependentAxes(settings))


def _coupled(settings: MotionSettings) -> Observer:
    return StaticOrMovingObserver(settings, InteractingModels(settings, [Model(settings.acceleration_noise, 1.0)]))


def _manoeuvring(settings: MotionSettings) -> Observer:
    noise, rest = settings.acceleration_noise, 0.5 * (1.0 - STEADY)
    models = [Model(settings.steady_noise, STEADY), Model(noise / AGILE, rest), Model(AGILE * noise, rest)]
    filters = InteractingModels(settings, models, CHANGE_RATE)
    return StaticOrMovingObserver(settings, filters, filters)


MakeObserver = Callable[[MotionSettings], Observer]

OBSERVERS: dict[str, MakeObserver] = {
    "independent": _independent,
    "coupled": _coupled,
    "manoeuvring": _manoeuvring,
}


def observer(name: str) -> Callable[[MakeObserver], MakeObserver]:
    """Register the decorated function, or class, that makes an observer. Raises PluginError when the name is taken."""

    def register(make: MakeObserver) -> MakeObserver:
        add(OBSERVERS, "observer", name, make)
        OBSERVER_NAMES[name] = None
        return make

    return register


def make_observer(name: str, settings: MotionSettings) -> Observer:
    """Return a new observer. Raises PluginError for a name that no plug-in has registered."""
    if name not in OBSERVERS:
        raise PluginError(f"tracker.observer: {none_of(name, OBSERVERS)}")
    return OBSERVERS[name](settings)
