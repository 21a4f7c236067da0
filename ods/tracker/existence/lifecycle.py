"""The states of an object [SSIE figure 5] and what leads from one to the next.

TENTATIVE -> ACTIVE                 proved by echoes (before that the planner does not hear of it)
TENTATIVE -> TERMINATED             not proved
ACTIVE    -> STAND_BY               out of view, or silent, or unseen until its place is not known: time updates only
STAND_BY  -> ACTIVE                 seen again
STAND_BY  -> HIBERNATED             out of view too long, not moving: into the map
STAND_BY  -> TERMINATED             out of view too long, moving; or gone
HIBERNATED -> ACTIVE                found again
HIBERNATED -> TERMINATED            its place is in full view, and it is gone
"""

from typing import NamedTuple

import msgspec

from ods.compiled import native
from ods.tracker.settings import LifeSettings

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


class Evidence(NamedTuple):
    """Result of the newest scan for an object."""

    hit: bool
    inside: bool
    """The predicted place is in the sonar's view,"""
    skipped: bool
    """but where this image was not looked at, or blind."""
    echoes: int
    """Echoes so far."""
    unseen_s: float
    """Time since the last one,"""
    missed_s: float
    """and how much of it images were looked at."""
    existence: float
    """Probability."""
    visible: float
    """Probability that it exists and gives echoes."""
    first_visible: float
    """The same when it began."""
    static: bool
    """It does not move, at a probability of at least `REST`."""
    covered: bool
    """It lies inside another object that is seen."""
    duplicate: bool
    """Its echoes may be those of a confirmed object beside it."""
    sigma: float
    """Standard deviation of its horizontal position, m."""


def next_state(state: int, e: Evidence, settings: LifeSettings) -> int:
    """Return an object's state after an image, reached by one of `TRANSITIONS` or unchanged."""
    after: int = native.next_state(state, e, msgspec.structs.astuple(settings))
    return after
