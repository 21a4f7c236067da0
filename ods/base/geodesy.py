"""WGS 84: latitude, longitude and height to and from a local north-east-down frame, exactly, by earth-centred axes.

The local frame is the plane that touches the ellipsoid at its origin (height 0): "down" of a place 10 km away is
8 m more than its depth below the ellipsoid. Heights are above the ellipsoid, not above the sea.
Constants: NIMA TR8350.2, third edition. Inverse: B. R. Bowring, Survey Review 23 (1976), 323-327, repeated.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from ods.base.arrays import Floats
from ods.base.frames.quaternion import Quaternion, Vector3
from ods.base.settings import Settings

SEMI_MAJOR_M = 6378137.0
FLATTENING = 1.0 / 298.257223563
SEMI_MINOR_M = SEMI_MAJOR_M * (1.0 - FLATTENING)
ECCENTRICITY_2 = FLATTENING * (2.0 - FLATTENING)
"""First eccentricity, squared."""
REPETITIONS = 2
"""Of Bowring's formula: one is off by 4 um at 20 km height, two by no more than rounding (4 nm) up to 1000 km from the
surface, up or down."""


class SiteSettings(Settings, frozen=True):
    """Origin of the local north-east-down frame."""

    latitude_deg: Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)]
    longitude_deg: Annotated[float, msgspec.Meta(ge=-180.0, le=180.0)]


def ecef_of(latitude_deg: ArrayLike, longitude_deg: ArrayLike, height_m: ArrayLike) -> Floats:
    """Return (..., 3) earth-centred, earth-fixed coordinates, m."""
    latitude, longitude, height = np.radians(latitude_deg), np.radians(longitude_deg), np.asarray(height_m, np.float64)
    sine, cosine = np.sin(latitude), np.cos(latitude)
    normal = SEMI_MAJOR_M / np.sqrt(1.0 - ECCENTRICITY_2 * sine**2)
    from_axis = (normal + height) * cosine
    up = (normal * (1.0 - ECCENTRICITY_2) + height) * sine
    x, y = from_axis * np.cos(longitude), from_axis * np.sin(longitude)
    ecef = np.empty((*np.broadcast(x, y, up).shape, 3))  # for one place faster than np.stack
    ecef[..., 0], ecef[..., 1], ecef[..., 2] = x, y, up
    return ecef


def geodetic_of(ecef: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Return latitude in deg, longitude in deg [-180, 180) and height in m of (..., 3) earth-centred coordinates."""
    x, y, z = np.moveaxis(np.asarray(ecef, np.float64), -1, 0)
    from_axis = np.hypot(x, y)
    reduced = np.arctan2(z, from_axis * (1.0 - FLATTENING))
    latitude = reduced
    for _ in range(REPETITIONS):
        above = z + SEMI_MINOR_M * ECCENTRICITY_2 / (1.0 - ECCENTRICITY_2) * np.sin(reduced) ** 3
        latitude = np.arctan2(above, from_axis - SEMI_MAJOR_M * ECCENTRICITY_2 * np.cos(reduced) ** 3)
        reduced = np.arctan2((1.0 - FLATTENING) * np.sin(latitude), np.cos(latitude))
    sine = np.sin(latitude)
    height = from_axis * np.cos(latitude) + z * sine - SEMI_MAJOR_M * np.sqrt(1.0 - ECCENTRICITY_2 * sine**2)
    longitude = (np.degrees(np.arctan2(y, x)) + 180.0) % 360.0 - 180.0
    return np.degrees(latitude), longitude, height


@dataclass(frozen=True, slots=True)
class LocalFrame:
    """North-east-down frame that touches the ellipsoid at an origin."""

    latitude_deg: float
    longitude_deg: float

    def rotation(self) -> Floats:
        """Return the (3, 3) matrix that turns north-east-down vectors into earth-centred ones."""
        return _rotation(self.latitude_deg, self.longitude_deg)

    def geodetic(self, ned: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Return latitude, longitude in deg and height in m of (..., 3) local positions."""
        return geodetic_of(self._origin() + np.asarray(ned, np.float64) @ self.rotation().T)

    def ned(self, latitude_deg: ArrayLike, longitude_deg: ArrayLike, height_m: ArrayLike) -> Floats:
        """Return (..., 3) local positions of places on the earth."""
        return (ecef_of(latitude_deg, longitude_deg, height_m) - self._origin()) @ self.rotation()

    def turn(self, latitude_deg: float, longitude_deg: float) -> Quaternion:
        """Return the attitude of a place: it turns vectors north, east, down there into local ones.

        Exact: the product of the turns by -(90 deg + latitude) about east, by the difference in longitude about the
        earth's axis, and by 90 deg + the origin's latitude about east. Its part about down is the meridians'
        convergence, 0.14 deg at 57 deg north and 10 km to the east.
        """
        east = 0.5 * math.radians(math.remainder(longitude_deg - self.longitude_deg, 360.0))  # across 180 deg, too
        south = 0.5 * math.radians(self.latitude_deg - latitude_deg)
        middle = 0.5 * math.radians(self.latitude_deg + latitude_deg)
        cosine, sine = math.cos(east), math.sin(east)
        return (
            cosine * math.cos(south),
            sine * math.cos(middle),
            cosine * math.sin(south),
            -sine * math.sin(middle),
        )

    def turn_at(self, ned: Vector3) -> Quaternion:
        """Return `turn` for the place at a local position, m, in plain floats: `geodetic` takes 20 times as long."""
        north, east, down = ned
        sine, cosine = math.sin(math.radians(self.latitude_deg)), math.cos(math.radians(self.latitude_deg))
        normal = SEMI_MAJOR_M / math.sqrt(1.0 - ECCENTRICITY_2 * sine * sine)
        outward = (normal - down) * cosine - north * sine
        along_axis = (normal * (1.0 - ECCENTRICITY_2) - down) * sine + north * cosine
        from_axis = math.hypot(outward, east)
        reduced = math.atan2(along_axis, from_axis * (1.0 - FLATTENING))
        latitude = math.atan2(
            along_axis + SEMI_MINOR_M * ECCENTRICITY_2 / (1.0 - ECCENTRICITY_2) * math.sin(reduced) ** 3,
            from_axis - SEMI_MAJOR_M * ECCENTRICITY_2 * math.cos(reduced) ** 3,
        )
        return self.turn(math.degrees(latitude), self.longitude_deg + math.degrees(math.atan2(east, outward)))

    def _origin(self) -> Floats:
        return _ground(self.latitude_deg, self.longitude_deg)


@lru_cache(maxsize=8)
def _rotation(latitude_deg: float, longitude_deg: float) -> Floats:
    latitude, longitude = np.radians(latitude_deg), np.radians(longitude_deg)
    north = [-np.sin(latitude) * np.cos(longitude), -np.sin(latitude) * np.sin(longitude), np.cos(latitude)]
    east = [-np.sin(longitude), np.cos(longitude), 0.0]
    down = [-np.cos(latitude) * np.cos(longitude), -np.cos(latitude) * np.sin(longitude), -np.sin(latitude)]
    return _read_only(np.array([north, east, down]).T)


@lru_cache(maxsize=8)
def _ground(latitude_deg: float, longitude_deg: float) -> Floats:
    return _read_only(ecef_of(latitude_deg, longitude_deg, 0.0))


def _read_only(array: Floats) -> Floats:
    array.flags.writeable = False
    return array
