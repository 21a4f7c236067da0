"""Paths in time: where objects and the vehicle are, and how the vehicle is turned."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.sim_sonar.pose import Times
from ods.sim_sonar.scene.settings import Oscillation, Path, VehiclePath

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

STILL = np.zeros(3)
LEAST_SPEED = 1e-6
"""Horizontal speed below which a path has no heading, m/s."""


class Moving(Protocol):
    """What has a place, a velocity and an attitude at any time (...): see `VehicleMotion`."""

    def position(self, t_s: Times) -> Floats:
        """Return (..., 3) NED, m."""

    def velocity(self, t_s: Times) -> Floats:
        """Return (..., 3) NED, m/s."""

    def attitude(self, t_s: Times) -> Floats:
        """Return (..., 4) unit quaternions, body to global."""


class Motion:
    """A path: constant velocity, or a natural cubic spline through waypoints that goes on straight at both ends."""

    def __init__(self, path: Path) -> None:
        self._start = np.array(path.position_ned or (0.0, 0.0, 0.0))
        self._velocity = np.array(path.velocity_ned)
        self._spline: CubicSpline | None = None
        if path.waypoints:
            times = [point.t_s for point in path.waypoints]
            from scipy import interpolate  # 40 MB: only where a path has way-points

            places = [point.position_ned for point in path.waypoints]
            self._spline = interpolate.CubicSpline(times, places, bc_type="natural")

    def position(self, t_s: Times) -> Floats:
        """Return (..., 3) NED, m, at times (...)."""
        if self._spline is None:
            return np.asarray(self._start + np.multiply.outer(t_s, self._velocity))
        inside = self._clamp(t_s)
        return np.asarray(self._spline(inside) + (t_s - inside)[..., None] * self._spline(inside, 1))

    def velocity(self, t_s: Times) -> Floats:
        """Return (..., 3) NED, m/s, the derivative of `position`."""
        if self._spline is None:
            return np.asarray(self._velocity + np.multiply.outer(t_s, STILL))
        return np.asarray(self._spline(self._clamp(t_s), 1))

    def _clamp(self, t_s: Times) -> Floats:
        assert self._spline is not None
        return np.asarray(np.minimum(np.maximum(t_s, self._spline.x[0]), self._spline.x[-1]))


class Motions:
    """Many paths together."""

    def __init__(self, paths: Sequence[Path]) -> None:
        self.each = [Motion(path) for path in paths]
        self._start = np.array([motion._start for motion in self.each]).reshape(-1, 3)
        self._velocity = np.array([motion._velocity for motion in self.each]).reshape(-1, 3)
        self._bent = [which for which, motion in enumerate(self.each) if motion._spline is not None]

    def positions(self, t_s: float) -> Floats:
        """Return (n, 3) NED, m."""
        places = self._start + self._velocity * t_s
        for which in self._bent:
            places[which] = self.each[which].position(t_s)
        return places


class VehicleMotion(Motion):
    """A vehicle's path with its attitude."""

    def __init__(self, path: VehiclePath) -> None:
        super().__init__(path)
        self._path = path

    def attitude(self, t_s: Times) -> Floats:
        """Return the (..., 4) unit quaternions, body to global, at times (...)."""
        roll, pitch, yaw = (_swing(part, t_s) for part in (self._path.roll, self._path.pitch, self._path.yaw))
        return geometry.quat_from_euler(roll, pitch, self._heading(t_s) + yaw)

    def _heading(self, t_s: Times) -> float | Floats:
        """Return the path's heading, rad, without the swing."""
        heading = math.radians(self._path.heading_deg)
        if not self._path.follow_path:
            return heading
        velocity = self.velocity(t_s)
        north, east = velocity[..., 0], velocity[..., 1]
        return np.where(np.hypot(north, east) > LEAST_SPEED, np.arctan2(east, north), heading)


def _swing(part: Oscillation, t_s: Times) -> float | Floats:
    phase = (2.0 * math.pi / part.period_s) * t_s + math.radians(part.phase_deg)
    return np.asarray(math.radians(part.amplitude_deg) * np.sin(phase))
