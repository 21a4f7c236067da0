"""The states of an object [SSIE figure 5] and what leads from one to the next, for all objects at once.

TENTATIVE -> ACTIVE                 proved by echoes (before that the planner does not hear of it)
TENTATIVE -> TERMINATED             not proved
ACTIVE    -> STAND_BY               out of view, or silent, or unseen until its place is not known: time updates only
STAND_BY  -> ACTIVE                 seen again
STAND_BY  -> HIBERNATED             out of view too long, not moving: into the map
STAND_BY  -> TERMINATED             out of view too long, moving or intermittent; or gone
HIBERNATED -> ACTIVE                found again
HIBERNATED -> TERMINATED            its place is in full view, and it is gone
"""

from typing import NamedTuple

import msgspec

from ods.base.arrays import Floats, Ints, Mask
from ods.compiled.kernel import kernel
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

TENTATIVE_SILENT_S = 1.0
"""An object not proved is given up after so long without an echo."""
TENTATIVE_DOUBT = 0.03
"""An object not proved is given up when its probability falls to this share of what it began with: two misses."""


class Evidence(NamedTuple):
    """What the newest image says of n objects: (n,) each."""

    hit: Mask
    inside: Mask
    """The predicted place is in the sonar's view,"""
    skipped: Mask
    """but where this image was not looked at, or blind."""
    echoes: Ints
    """Echoes so far."""
    unseen_s: Floats
    """Time since the last one,"""
    missed_s: Floats
    """and how much of it images were looked at."""
    existence: Floats
    """Probability."""
    visible: Floats
    """Probability that it exists and gives echoes."""
    first_visible: Floats
    """The same when it began."""
    static: Mask
    """It does not move, at a probability of at least `REST`."""
    covered: Mask
    """It lies inside another object that is seen."""
    duplicate: Mask
    """Its echoes may be those of a confirmed object beside it."""
    intermittent: Mask
    """Seen as places are where echoes come and go, not as objects are: nothing for the map."""
    sigma: Floats
    """Standard deviation of its horizontal position, m."""


class LifeLimits(NamedTuple):
    """`LifeSettings`, for the compiled loop."""

    confirm_echoes: int
    confirm_existence: float
    drop_existence: float
    edge_sigmas: float
    silent_s: float
    stand_by_s: float
    lost_sigma_m: float


def next_states(state: Ints, e: Evidence, settings: LifeSettings) -> Ints:
    """Return the states after an image, reached by one of `TRANSITIONS` each or unchanged."""
    return _next_states(state, e, LifeLimits(*msgspec.structs.astuple(settings)))


@kernel
def _next_states(state: Ints, e: Evidence, limits: LifeLimits) -> Ints:
    after = state.copy()
    for i in range(len(state)):
        doubted = e.existence[i] < limits.drop_existence
        if state[i] == TENTATIVE:
            after[i] = _proved_or_not(e, i, limits)
        elif state[i] == ACTIVE:
            missed = e.missed_s[i] > limits.silent_s and not e.skipped[i]
            lost = e.skipped[i] and e.sigma[i] > limits.lost_sigma_m
            if not e.hit[i] and (not e.inside[i] or doubted or missed or lost):
                after[i] = STAND_BY
        elif state[i] == STAND_BY or state[i] == HIBERNATED:
            lasting = e.static[i] and not e.intermittent[i]
            overdue = (not e.inside[i] and e.unseen_s[i] > limits.stand_by_s) or e.sigma[i] > limits.lost_sigma_m
            if e.hit[i]:
                after[i] = ACTIVE
            elif doubted or (state[i] == STAND_BY and (e.covered[i] or (overdue and not lasting))):
                after[i] = TERMINATED
            elif overdue:
                after[i] = HIBERNATED
    return after


@kernel
def _proved_or_not(e: Evidence, i: int, limits: LifeLimits) -> int:
    """Return the next state of a tentative object."""
    if e.hit[i]:
        proved = e.echoes[i] >= limits.confirm_echoes and e.existence[i] >= limits.confirm_existence
        return ACTIVE if proved and not e.duplicate[i] else TENTATIVE
    if e.skipped[i]:
        return TENTATIVE
    unproved = e.visible[i] < TENTATIVE_DOUBT * e.first_visible[i] or e.missed_s[i] > TENTATIVE_SILENT_S
    return TERMINATED if unproved else TENTATIVE
