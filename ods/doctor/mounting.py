"""The mounting of sonar and INS in words, to be checked by an installer."""

import math
from collections.abc import Iterator

from ods.base.frames.mounting import Lever, MountingSettings
from ods.doctor.finding import Finding

WAYS = ("ahead", "astern"), ("to starboard", "to port"), ("down", "up")
"""Along forward, starboard and down, and against them."""
MAYBE_RADIANS = 1.6
"""A right angle and what it was rounded up by; angles in degrees are larger as a rule."""
STEEPEST_DEG = 50.0
"""Tilt of the fan beyond which positions are off by more than their standard deviations (docs/hardware/mounting.md)."""


def examine(mounting: MountingSettings, lever_arm_m: Lever) -> Iterator[Finding]:
    """Yield where the configuration puts sonar and INS."""
    yield Finding("good", "mounting", f"the sonar is {words_of(mounting)}")
    angles = [angle for angle in (mounting.roll_deg, mounting.pitch_deg, mounting.yaw_deg) if angle]
    if angles and max(map(abs, angles)) < MAYBE_RADIANS:
        converted = " and ".join(f"{angle:g} would be {math.degrees(angle):.1f} deg" for angle in angles)
        yield Finding("note", "mounting", f"angles of sonar.mounting are degrees; if these are radians, {converted}")
    steep = _from_level_deg(mounting)
    if steep > STEEPEST_DEG:
        why = f"beyond {STEEPEST_DEG:.0f} deg position errors exceed their reported sigma"
        yield Finding("note", "mounting", f"sonar.mounting puts the fan {steep:.0f} deg from level: {why}")
    if any(lever_arm_m):
        yield Finding("good", "mounting", f"the INS is {_way(lever_arm_m)} of the vehicle's origin")


def _from_level_deg(mounting: MountingSettings) -> float:
    """Return the angle between the fan's plane and the vehicle's, the same for one mounted upside down."""
    upright = math.cos(math.radians(mounting.roll_deg)) * math.cos(math.radians(mounting.pitch_deg))
    return math.degrees(math.acos(min(abs(upright), 1.0)))


def words_of(mounting: MountingSettings) -> str:
    """Return a mounting in words."""
    way = _way(mounting.position_m)
    turns = [
        f"{abs(angle):g} deg {sides[angle < 0.0]}"
        for angle, sides in (
            (mounting.yaw_deg, ("to starboard", "to port")),
            (mounting.pitch_deg, ("up", "down")),
        )
        if angle
    ]
    looks = f"looks {' and '.join(turns)}" if turns else "looks straight ahead"
    side = "starboard" if mounting.roll_deg > 0.0 else "port"
    rolled = f", rolled {abs(mounting.roll_deg):g} deg to {side}" if mounting.roll_deg else ""
    return f"{f'{way} of' if way else 'at'} the vehicle's origin and {looks}{rolled}"


def _way(place_m: Lever) -> str:
    return ", ".join(f"{abs(part):g} m {ways[part < 0.0]}" for part, ways in zip(place_m, WAYS, strict=True) if part)
