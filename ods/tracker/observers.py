"""The library of observers: filters for the states of all objects at once, chosen by name [SSIE].

An observer keeps one column an object, in the order in which they were started; `Tracker` keeps its own columns in
step. `OBSERVERS` maps the name in the configuration to a factory that takes the motion settings.
"""

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.tracker.belief import Belief
from ods.tracker.independent import IndependentObserver
from ods.tracker.measurement import Fix
from ods.tracker.settings import MotionSettings


class Observer(Protocol):
    """What the tracker asks of a set of filters. `rows` are indices of objects."""

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""

    def belief(self) -> Belief:
        """Return the hypotheses of all objects; the arrays may be views that the next change spoils."""

    def velocity(self) -> tuple[Array, Array]:
        """Return mean and variance (3, n) of all velocities."""

    def start(self, fix: Fix) -> None:
        """Append new objects, one a fix."""

    def recall(self, position: Array, variance: Array, radius: Array, radius_variance: Array) -> None:
        """Append objects from the map, known not to move: (3, k), (3, k), (k,), (k,)."""

    def update(self, rows: NDArray[np.intp], fix: Fix, since_s: Array) -> None:
        """Take one fix an object, `since_s` after its last one."""

    def settle(self, rows: NDArray[np.intp]) -> None:
        """Decide for good whether each object moves, where that is established: the static ones stay where they are."""

    def rest(self, rows: NDArray[np.intp]) -> None:
        """Decide for good that objects do not move: they are where they were when seen."""

    def reopen(self, rows: NDArray[np.intp]) -> None:
        """Take the decision of `settle` back: the object is seen again."""

    def inherit(self, heirs: NDArray[np.intp], old: NDArray[np.intp]) -> None:
        """Let `heirs` go on with what is settled of `old`: they are the same objects, seen again."""

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Remove the objects where `mask` is False."""


OBSERVERS: dict[str, Callable[[MotionSettings], Observer]] = {"independent": IndependentObserver}


def make_observer(name: str, settings: MotionSettings) -> Observer:
    """Return a new observer. Raises ValueError for an unknown name."""
    if name not in OBSERVERS:
        raise ValueError(f"tracker.observer: no observer {name!r}; there are: {', '.join(sorted(OBSERVERS))}")
    return OBSERVERS[name](settings)
