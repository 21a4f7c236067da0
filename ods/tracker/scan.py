"""What one ping gives the tracker: the vehicle's pose, the sonar's sector and the echoes, as plain arrays."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ods.geometry import Array, rotation_matrix
from ods.messages import Detection, Sector


@dataclass(frozen=True, slots=True)
class Vehicle:
    """The vehicle at the ping."""

    position: Array
    """(3,) NED, m."""
    rotation: Array
    """(3, 3) body to global: R^-1 of eq. 1."""
    sigma_position: Array
    """(3,) north, east, down, m."""
    sigma_attitude: Array
    """(3,) roll, pitch, yaw, rad."""


def vehicle_at(position: Array, attitude: Array, sigma_position: Array, sigma_attitude: Array) -> Vehicle | None:
    """Return the vehicle of a pose (quaternion w, x, y, z, body to global); None when a number is not finite."""
    if not np.isfinite(np.concatenate([position, attitude, sigma_position, sigma_attitude])).all():
        return None
    return Vehicle(position, rotation_matrix(attitude), sigma_position, sigma_attitude)


@dataclass(frozen=True, slots=True)
class Echoes:
    """The detections of one ping, (m,) each: m, rad."""

    range_m: Array
    bearing: Array
    elevation: Array
    """Of the plane the echo was seen in, up positive."""
    radius: Array
    sigma_range: Array
    sigma_bearing: Array
    sigma_radius: Array

    def __len__(self) -> int:
        return len(self.range_m)

    def take(self, rows: NDArray[np.intp]) -> "Echoes":
        """Return the echoes of an index array."""
        return Echoes(*(getattr(self, name)[rows] for name in Echoes.__slots__))

    def joined(self, other: "Echoes") -> "Echoes":
        """Return the echoes of both."""
        return Echoes(*(np.concatenate([getattr(self, name), getattr(other, name)]) for name in Echoes.__slots__))


SMALLEST_SIGMA = 1e-4
"""Standard deviations below this (m, rad) are no claim a sonar can make; they are raised to it."""
LARGEST = 1e5
"""No range, radius or standard deviation of a sonar is larger."""


def echoes_of(table: Array) -> tuple[Echoes, int]:
    """Return the echoes of a (m, 7) table with the columns of `Echoes`, and how many rows were dropped as not usable.

    Dropped: numbers that are not finite or absurdly large, ranges not above 0, negative radii or standard deviations.
    """
    good = (np.abs(table) <= LARGEST).all(axis=1) & (table[:, 0] > 0.0) & (table[:, 3:] >= 0.0).all(axis=1)
    columns = np.ascontiguousarray(table[good].T)
    np.maximum(columns[4:], SMALLEST_SIGMA, out=columns[4:])
    return Echoes(*columns), int(len(good) - np.count_nonzero(good))


def table_of(detections: list[Detection]) -> Array:
    """Return the (m, 7) table of `echoes_of` for a message's detections."""
    rows = [
        (d.range_m, d.bearing_rad, d.elevation_rad, d.radius_m, d.sigma_range_m, d.sigma_bearing_rad, d.sigma_radius_m)
        for d in detections
    ]
    return np.array(rows, np.float64).reshape(-1, 7)


@dataclass(frozen=True, slots=True)
class Scan:
    """One ping."""

    t_ns: int
    """Transmit time, CLOCK_MONOTONIC or any other clock that never goes back."""
    utc_ns: int
    vehicle: Vehicle | None
    """None when no pose is known for this time: then objects are only carried on in time."""
    sector: Sector
    echoes: Echoes
    usable: bool = True
    """False when the whole image shows nothing: then a missing echo says nothing."""
    looked: Sequence[tuple[float, float]] = ()
    """Ranges (from, to) that were processed, m; empty: all. Elsewhere a missing echo says nothing."""
