"""Position and orientation of the sonar's head on the vehicle, and its pose in the world.

The head's frame is the body frame (forward, starboard, down) turned by yaw, pitch and roll in this order, as the
vehicle is in the global one; its x axis is bearing 0, elevation 0. So pitch below 0 looks down. All that an image shows
is measured from the head; docs/hardware/mounting.md has a drawing.
"""

import copy
import math
from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.base.frames.geometry import rotation_matrix
from ods.base.frames.quaternion import Quaternion, Vector3, from_euler, product, rotated
from ods.base.settings import Settings, slider
from ods.base.settings_file import load

LeverArm = Annotated[float, msgspec.Meta(ge=-100.0, le=100.0), slider(-20.0, 20.0, unit="m")]
"""A coordinate of a place on the vehicle, m."""
Lever = tuple[LeverArm, LeverArm, LeverArm]
"""A place on the vehicle: forward, starboard and down of the body's origin, m."""
HalfTurn = Annotated[float, msgspec.Meta(ge=-180.0, le=180.0)]
QuarterTurn = Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)]


class MountingSettings(Settings, frozen=True):
    """The head on the vehicle (docs/hardware/mounting.md)."""

    position_m: Lever = (0.0, 0.0, 0.0)
    """Forward, starboard, down of the body's origin."""
    roll_deg: HalfTurn = 0.0
    """Positive: starboard side down; 180: upside down."""
    pitch_deg: QuarterTurn = 0.0
    """Positive: up."""
    yaw_deg: HalfTurn = 0.0
    """Positive: to starboard. Applied in the order yaw, pitch, roll."""


class _SonarTable(Settings, frozen=True, forbid_unknown_fields=False):
    mounting: MountingSettings = MountingSettings()


class _NavTable(Settings, frozen=True, forbid_unknown_fields=False):
    lever_arm_m: Lever = (0.0, 0.0, 0.0)


class _OnboardFile(Settings, frozen=True, forbid_unknown_fields=False):
    sonar: _SonarTable = _SonarTable()
    nav: _NavTable = _NavTable()


def mounting_in(config: Path) -> MountingSettings:
    """Return `[sonar.mounting]` of an on-board configuration, without a look at the rest. Raises ConfigError."""
    return load(config, _OnboardFile).sonar.mounting


def lever_arm_in(config: Path) -> Vector3:
    """Return `nav.lever_arm_m` of an on-board configuration likewise, m. Raises ConfigError."""
    return load(config, _OnboardFile).nav.lever_arm_m


def spread_at(lever_ned: Vector3, sigma_position: Vector3, sigma_attitude: Vector3) -> Vector3:
    """Return the 1-sigma, m, of a place `lever_ned` m from one known to `sigma_position`: attitude errors swing it.

    sigma_attitude: roll, pitch, yaw, rad; the larger tilt counts about any level axis, yaw about the vertical.
    """
    north, east, down = lever_ned
    tilt, yaw = max(sigma_attitude[0], sigma_attitude[1]), sigma_attitude[2]
    return (
        math.hypot(sigma_position[0], yaw * east, tilt * down),
        math.hypot(sigma_position[1], yaw * north, tilt * down),
        math.hypot(sigma_position[2], tilt * math.hypot(north, east)),
    )


class Mounting:
    """Turns poses of the vehicle into those of the sonar's head."""

    def __init__(self, settings: MountingSettings) -> None:
        self.lever: Vector3 = settings.position_m
        """Forward, starboard, down, m."""
        self.turn: Quaternion = from_euler(
            math.radians(settings.roll_deg), math.radians(settings.pitch_deg), math.radians(settings.yaw_deg)
        )
        """Head to body."""
        self.is_none = settings == MountingSettings()
        """The head is the vehicle."""
        self._after = _multiplied_after(self.turn)

    def with_head_turned(self, angle_rad: float) -> "Mounting":
        """Return the same head turned to its starboard about its own down axis."""
        other = copy.copy(self)
        other.turn = product(self.turn, from_euler(0.0, 0.0, angle_rad))
        other.is_none = False
        other._after = _multiplied_after(other.turn)
        return other

    def head(self, position_ned: Vector3, attitude: Quaternion) -> tuple[Vector3, Quaternion, Vector3]:
        """Return place, m, and attitude (head to global) of the head, and the way to it from the body's origin, m."""
        north, east, down = rotated(attitude, self.lever)
        place = position_ned[0] + north, position_ned[1] + east, position_ned[2] + down
        return place, product(attitude, self.turn), (north, east, down)

    def heads(self, position_ned: Floats, attitude: Floats) -> tuple[Floats, Floats]:
        """Return (..., 3) places and (..., 4) attitudes of the head for those of the vehicle."""
        return position_ned + rotation_matrix(attitude) @ np.array(self.lever), attitude @ self._after


def _multiplied_after(turn: Quaternion) -> Floats:
    """Return the matrix by which rows of quaternions are multiplied with `turn` behind them."""
    w, x, y, z = turn
    return np.array([[w, x, y, z], [-x, w, -z, y], [-y, z, w, -x], [-z, -y, x, w]])


AT_ORIGIN = Mounting(MountingSettings())
"""The head is at the vehicle's origin, and points along its bow."""
