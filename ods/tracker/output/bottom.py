"""Objects that may be the bottom, by their heights above it."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Mask
from ods.compiled import native
from ods.pose.buffer import PoseEstimate
from ods.tracker.output.snapshot import Snapshot
from ods.tracker.settings import BottomSettings


class Bottom(NamedTuple):
    """The bottom right below the vehicle."""

    place: Floats
    """(3,) NED, m."""
    sigma_m: float
    """Standard deviation of its depth below the vehicle."""


class HeightAboveBottom(NamedTuple):
    """Heights of n objects above the bottom: (n,) each."""

    height_m: Floats
    """Of the middle of what is seen of them,"""
    sigma_m: Floats
    """and its standard deviation."""
    bottom: Floats
    """Probability that they reach no higher than the clearance over it."""


def bottom_below(vehicle: PoseEstimate | None) -> Bottom | None:
    """Return the bottom below a vehicle that knows its altitude."""
    if vehicle is None or vehicle.altitude_m is None:
        return None
    return Bottom(vehicle.position_ned + np.array([0.0, 0.0, vehicle.altitude_m]), vehicle.sigma_altitude_m)


def heights_above_bottom(snapshot: Snapshot, bottom: Bottom, settings: BottomSettings) -> HeightAboveBottom:
    """Return how the objects stand, given that nothing is below the bottom."""
    away = np.hypot(*(snapshot.position[:2] - bottom.place[:2, None]))
    height = bottom.place[2] - snapshot.position[2]
    slope = np.tan(np.radians(settings.slope_deg)) * away
    sigma = np.sqrt(snapshot.sigma_position[2] ** 2 + bottom.sigma_m**2 + slope**2 + settings.roughness_m**2)
    probability = np.empty(len(snapshot))
    native.reach_no_higher(height, sigma, settings.clearance_m, probability)
    return HeightAboveBottom(height, sigma, probability)


def is_reportable(snapshot: Snapshot, bottom: Bottom | None, settings: BottomSettings) -> Mask:
    """Return (n,) bool: objects that the settings let the planner receive; all of them where the bottom is unknown."""
    if bottom is None or settings.list == "all":
        return np.ones(len(snapshot), bool)
    return np.asarray(1.0 - heights_above_bottom(snapshot, bottom, settings).bottom >= settings.risk)
