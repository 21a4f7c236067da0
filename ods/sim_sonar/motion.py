"""Paths in time: where objects and the vehicle are, and how the vehicle is turned."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from ods import geometry
from ods.sim_sonar.scene_settings import Oscillation, Path, VehiclePath

Array = NDArray[np.float64]

SLOW = 1e-6
"""Horizontal speed below which a path has no heading, m/s."""


class Motion:
    """A path: constant velocity, or a natural cubic spline through waypoints that goes on straight at both ends."""

    def __init__(self, path: Path) -> None:
        self._start = np.array(path.position_ned or (0.0, 0.0, 0.0))
        self._velocity = np.array(path.velocity_ned)
        self._spline: CubicSpline | None = None
        if path.waypoints:
            times = [point.t_s for point in path.waypoints]
            self._spline = CubicSpline(times, [point.position_ned for point in path.waypoints], bc_type="natural")

    def position(self, t_s: float) -> Array:
        """Return (3,) NED, m."""
        if self._spline is None:
            return np.asarray(self._start + t_s * self._velocity)
        inside = self._clamp(t_s)
        return np.asarray(self._spline(inside) + (t_s - inside) * self._spline(inside, 1))

    def velocity(self, t_s: float) -> Array:
        """Return (3,) NED, m/s, the derivative of `position`."""
        if self._spline is None:
            return self._velocity.copy()
        return np.asarray(self._spline(self._clamp(t_s), 1))

    def _clamp(self, t_s: float) -> float:
        assert self._spline is not None
        return float(min(max(t_s, self._spline.x[0]), self._spline.x[-1]))


class VehicleMotion(Motion):
    """A vehicle's path with its attitude."""

    def __init__(self, path: VehiclePath) -> None:
        super().__init__(path)
        self._path = path

    def attitude(self, t_s: float) -> Array:
        """Return the (4,) unit quaternion, body to global."""
        heading = math.radians(self._path.heading_deg)
        north, east, _ = self.velocity(t_s)
        if self._path.follow_path and math.hypot(north, east) > SLOW:
            heading = math.atan2(east, north)
        roll, pitch, yaw = (_swing(part, t_s) for part in (self._path.roll, self._path.pitch, self._path.yaw))
        return geometry.quat_from_euler(roll, pitch, heading + yaw)


def _swing(part: Oscillation, t_s: float) -> float:
    phase = 2.0 * math.pi * t_s / part.period_s + math.radians(part.phase_deg)
    return math.radians(part.amplitude_deg) * math.sin(phase)
