"""The states of an object [SSIE figure 5] and what leads from one to the next, for all objects at once.

TENTATIVE -> ACTIVE                 proved by echoes (before that the planner does not hear of it)
TENTATIVE -> TERMINATED             not proved
ACTIVE    -> STAND_BY               out of view, or silent: time updates only
STAND_BY  -> ACTIVE                 seen again
STAND_BY  -> HIBERNATED             out of view too long, not moving: into the map
STAND_BY  -> TERMINATED             out of view too long, moving; or gone
HIBERNATED -> ACTIVE                found again
HIBERNATED -> TERMINATED            its place is in full view, and it is gone
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array
from ods.tracker.settings import LifeSettings

Mask = NDArray[np.bool_]


TENTATIVE, ACTIVE, STAND_BY, HIBERNATED, TERMINATED = range(5)
"""States of an object; ACTIVE to HIBERNATED are reported."""

TRANSITIONS: dict[int, tuple[int, ...]] = {
    TENTATIVE: (ACTIVE, TERMINATED),
    ACTIVE: (STAND_BY,),
    STAND_BY: (ACTIVE, HIBERNATED, TERMINATED),
    HIBERNATED: (ACTIVE, TERMINATED),
    TERMINATED: (),
}
"""The only changes there are."""

STATIC = 0.95
"""An object is fit for the map if its velocity cannot be told from zero: it is static with this probability."""
TENTATIVE_SILENT_S = 1.0
"""An object not proved is given up after so long without an echo."""
TENTATIVE_DOUBT = 0.03
"""An object not proved is given up when its probability falls to this share of what it began with: two misses."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """What the newest image says of n objects: (n,) each."""

    hit: Mask
    inside: Mask
    """The predicted place is in the sonar's view."""
    echoes: NDArray[np.int64]
    """Echoes so far."""
    unseen_s: Array
    """Time since the last one."""
    existence: Array
    """Probability."""
    visible: Array
    """Probability that it exists and gives echoes."""
    first_visible: Array
    """The same when it began."""
    static: Mask
    """It does not move, at a probability of at least `STATIC`."""
    covered: Mask
    """It lies inside another object that is seen."""
    stray: Mask
    """Its echoes may be those of a confirmed object beside it."""
    sigma: Array
    """Standard deviation of its horizontal position, m."""


def next_states(state: NDArray[np.int64], e: Evidence, settings: LifeSettings) -> NDArray[np.int64]:
    """Return the states after an image, reached by one of `TRANSITIONS` each or unchanged."""
    doubted = e.existence < settings.drop_existence
    outside = ~e.inside
    tentative, stand_by, hibernated = state == TENTATIVE, state == STAND_BY, state == HIBERNATED
    after = state.copy()
    after[tentative & ~e.hit & _unproved(e)] = TERMINATED
    after[tentative & e.hit & _proved(e, settings)] = ACTIVE
    after[(state == ACTIVE) & ~e.hit & (outside | doubted | (e.unseen_s > settings.silent_s))] = STAND_BY
    after[hibernated & doubted] = TERMINATED
    if stand_by.any():
        overdue = stand_by & ((outside & (e.unseen_s > settings.stand_by_s)) | (e.sigma > settings.lost_sigma_m))
        after[overdue] = np.where(e.static[overdue], HIBERNATED, TERMINATED)
        after[stand_by & (doubted | e.covered)] = TERMINATED
    after[(stand_by | hibernated) & e.hit] = ACTIVE
    return after


def _proved(e: Evidence, settings: LifeSettings) -> Mask:
    return (e.echoes >= settings.confirm_echoes) & (e.existence >= settings.confirm_existence) & ~e.stray


def _unproved(e: Evidence) -> Mask:
    return (e.visible < TENTATIVE_DOUBT * e.first_visible) | (e.unseen_s > TENTATIVE_SILENT_S)
