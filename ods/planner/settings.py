"""Settings of the reference planner: [planner] of a campaign, and of the bench."""

import math
from pathlib import Path
from typing import Annotated, Literal

import msgspec

from ods.base.settings import NonNegative, NonNegativeSeconds, Positive, Seconds, Settings

MOST_M_S = 32.0
"""Speed that a set point can hold on CAN, m/s."""

Coordinate = Annotated[float, msgspec.Meta(ge=-1e7, le=1e7)]
Down = Annotated[float, msgspec.Meta(ge=-1e5, le=1e5)]


class SteeringSettings(Settings, frozen=True):
    """Steering, also without a valid list."""

    cruise_m_s: Positive = 2.0
    """Through the water."""
    slow_m_s: Positive = 1.0
    """Least speed at which it steers."""
    turn_rate_deg_s: Positive = 10.0
    acceleration_m_s2: Positive = 0.2
    """Along the course."""
    vehicle_radius_m: NonNegative = 0.5
    keep_m: NonNegative = 3.0
    """From the vehicle's circle to an obstacle's edge."""
    risk: Annotated[float, msgspec.Meta(gt=0.0, lt=0.5)] = 0.01
    """Highest accepted probability of coming nearer."""
    certain_s: NonNegativeSeconds = 3.0
    """Time ahead within which a risk counts fully."""
    expected_s: Seconds = 10.0
    """From `certain_s` to this time sigmas are reduced to 0."""
    horizon_s: Annotated[float, msgspec.Meta(gt=1.0, le=300.0)] = 30.0
    """Time ahead for which paths are checked."""
    headings: Annotated[int, msgspec.Meta(ge=8, le=360)] = 60
    """Candidates, evenly spaced."""
    look_m: Positive = 20.0
    """It goes slowly if less water ahead is known to be empty."""
    reached_m: Positive = 10.0
    """A way-point counts as reached within this distance, or within the turning circle."""
    stale_s: Seconds = 1.0
    """An older list counts as not valid."""
    not_valid: Literal["slow", "climb", "turn"] = "climb"
    """While the list is not valid: slow, clear of the last listed obstacles; after `not_valid_after_s` also climb to
    `climb_to_m`, or turn back."""
    not_valid_after_s: NonNegativeSeconds = 3.0
    climb_to_m: Down = 5.0
    """Down coordinate."""

    def __post_init__(self) -> None:
        if self.slow_m_s > self.cruise_m_s:
            raise ValueError("slow_m_s: must not be above cruise_m_s")
        if not self.certain_s < self.expected_s <= self.horizon_s:
            raise ValueError("expected_s: must be above certain_s, and not above horizon_s")

    @property
    def turn_rate_rad_s(self) -> float:
        """rad/s."""
        return math.radians(self.turn_rate_deg_s)


class PlannerCanSettings(Settings, frozen=True):
    """CAN to the simulated vehicle."""

    eds: Path
    """Of the vehicle (RPDO 1)."""
    interface: str = "socketcan"
    """As python-can names it; the bench replaces it."""
    channel: str = "vcan0"
    """The bench replaces it."""
    node_id: Annotated[int, msgspec.Meta(ge=1, le=127)] = 6
    """The vehicle's."""


class PlannerSettings(Settings, frozen=True):
    """The planner as a process."""

    way_points: Annotated[list[tuple[Coordinate, Coordinate, Down]], msgspec.Meta(min_length=1)]
    """North, east, down, m, in this order."""
    steering: SteeringSettings = SteeringSettings()
    can: PlannerCanSettings | None = None
    """None: set points are only published as messages."""

    def __post_init__(self) -> None:
        if self.steering.cruise_m_s > MOST_M_S:
            raise ValueError(f"steering.cruise_m_s: at most {MOST_M_S:g} m/s")


class PlannerConfig(Settings, frozen=True):
    """Configuration of the planner process."""

    planner: PlannerSettings | None = None
