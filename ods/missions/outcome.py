"""Outcome of a mission."""

from typing import Literal, NamedTuple

import msgspec

Ending = Literal["success", "collision", "time-out"]


class Flown(NamedTuple):
    """A mission and its computing time."""

    outcome: "Outcome"
    cpu_s: float
    """Of one core; no part of the results, which are the same at each time."""
    finding_ms: float | None = None
    """Median CPU time per ping of the pipeline, or of drawing detections; none: there is no list."""
    tracking_ms: float | None = None
    """Median CPU time per ping of the tracker."""


class Outcome(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One arm in one world."""

    mission: int
    """Number of the world."""
    arm: str
    ending: Ending
    near_miss: bool
    """It came nearer than the campaign's `near_miss_m`, without a collision."""
    clearance_m: float | None
    """Least distance between the vehicle's circle and an obstacle; below 0: a collision; none: no obstacles."""
    path_m: float
    """Length of the vehicle's way over ground."""
    time_s: float
    """Until the goal, the collision, or the end of patience."""
    evasions: int
    """Times that something in the way made the vehicle leave its course."""
    evasions_of_nothing: int
    """Those during which nothing real was in the way."""
    listed: int
    """Number of obstacles that were listed."""
    first_listed_m: float | None
    """Mean distance from the vehicle to their edges when first listed; none: none was."""
    time_to_collision_s: float | None
    """Time to collision at first confirmation: of the obstacles that the vehicle would have run into, going straight on
    as when they were listed first, the least time until then; 0: it ran into one that was never listed; none: there was
    no such, or there is no list."""
    not_valid_s: float
    """Time during which the planner had no list to rely on."""
    nearest_listed: bool
    """The obstacle that it came nearest to was listed in the last 5 s before."""
    warning: str
    """State of the list then: not valid, with a caution, or the water there never reported empty; otherwise nothing."""
