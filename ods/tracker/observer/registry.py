"""The library of observers: filters for the states of all objects at once, chosen by name [SSIE].

`OBSERVERS` maps the name in the configuration to a factory that takes the motion settings; a plug-in adds to it:

    @observer("brisk")
    def brisk(settings: MotionSettings) -> StaticOrMovingObserver:
        return StaticOrMovingObserver(settings, ...)
"""

from collections.abc import Callable

from ods.base.choices import none_of
from ods.base.plugins import PluginError, add
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


def _independent(settings: MotionSettings) -> StaticOrMovingObserver:
    return StaticOrMovingObserver(settings, IndependentAxes(settings))


def _coupled(settings: MotionSettings) -> StaticOrMovingObserver:
    return StaticOrMovingObserver(settings, InteractingModels(settings, [Model(settings.acceleration_noise, 1.0)]))


def _manoeuvring(settings: MotionSettings) -> StaticOrMovingObserver:
    noise, rest = settings.acceleration_noise, 0.5 * (1.0 - STEADY)
    models = [Model(settings.steady_noise, STEADY), Model(noise / AGILE, rest), Model(AGILE * noise, rest)]
    filters = InteractingModels(settings, models, CHANGE_RATE)
    return StaticOrMovingObserver(settings, filters, filters)


MakeObserver = Callable[[MotionSettings], StaticOrMovingObserver]

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


def make_observer(name: str, settings: MotionSettings) -> StaticOrMovingObserver:
    """Return a new observer. Raises PluginError for a name that no plug-in has registered."""
    if name not in OBSERVERS:
        raise PluginError(f"tracker.observer: {none_of(name, OBSERVERS)}")
    return OBSERVERS[name](settings)
