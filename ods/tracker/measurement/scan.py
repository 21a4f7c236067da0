"""What one ping gives the tracker: the vehicle's pose, the sonar's sector and the echoes, as plain arrays."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.base.geometry import rotation_matrix
from ods.messages import Detection, Sector


class Vehicle(NamedTuple):
    """The vehicle at the ping."""

    position: Floats
    """(3,) NED, m."""
    rotation: Floats
    """(3, 3) body to global: R^-1 of eq. 1."""
    sigma_position: Floats
    """(3,) north, east, down, m."""
    sigma_attitude: Floats
    """(3,) roll, pitch, yaw, rad."""


def vehicle_at(position: Floats, attitude: Floats, sigma_position: Floats, sigma_attitude: Floats) -> Vehicle | None:
    """Return the vehicle of a pose (quaternion w, x, y, z, body to global); None when a number is not finite."""
    if not np.isfinite(np.concatenate([position, attitude, sigma_position, sigma_attitude])).all():
        return None
    numbers = position, rotation_matrix(attitude), sigma_position, sigma_attitude
    return Vehicle(*(np.ascontiguousarray(array, np.float64) for array in numbers))


RANGE, BEARING, ELEVATION, RADIUS, SIGMA_RANGE, SIGMA_BEARING, SIGMA_RADIUS = range(7)
"""Rows of the table of `Echoes`."""


@dataclass(frozen=True, slots=True)
class Echoes:
    """The m detections of one ping."""

    table: Floats
    """(7, m) m, rad; row names as above."""

    def __len__(self) -> int:
        return int(self.table.shape[1])

    @property
    def range_m(self) -> Floats:
        """(m,)."""
        return self._row(RANGE)

    @property
    def bearing(self) -> Floats:
        """(m,)."""
        return self._row(BEARING)

    @property
    def elevation(self) -> Floats:
        """(m,) of the plane the echo was seen in, up positive."""
        return self._row(ELEVATION)

    @property
    def radius(self) -> Floats:
        """(m,)."""
        return self._row(RADIUS)

    @property
    def sigma_range(self) -> Floats:
        """(m,)."""
        return self._row(SIGMA_RANGE)

    @property
    def sigma_bearing(self) -> Floats:
        """(m,)."""
        return self._row(SIGMA_BEARING)

    @property
    def sigma_radius(self) -> Floats:
        """(m,)."""
        return self._row(SIGMA_RADIUS)

    def _row(self, row: int) -> Floats:
        view: Floats = self.table[row]
        return view

    def take(self, rows: Indices) -> "Echoes":
        """Return the echoes of an index array."""
        return Echoes(self.table.take(rows, axis=1))

    def joined(self, other: "Echoes") -> "Echoes":
        """Return the echoes of both."""
        return Echoes(np.concatenate([self.table, other.table], axis=1))


SMALLEST_SIGMA = 1e-4
"""Standard deviations below this (m, rad) are no claim a sonar can make; they are raised to it."""
LARGEST = 1e5
"""No range, radius or standard deviation of a sonar is larger."""


def echoes_of(table: Floats) -> tuple[Echoes, int]:
    """Return the echoes of a (m, 7) table with the columns of `Echoes`, and how many rows were dropped as not usable.

    Dropped: numbers that are not finite or absurdly large, ranges not above 0, negative radii or standard deviations.
    """
    good = (np.abs(table) <= LARGEST).all(axis=1) & (table[:, 0] > 0.0) & (table[:, 3:] >= 0.0).all(axis=1)
    columns = np.ascontiguousarray(table[good].T)
    np.maximum(columns[SIGMA_RANGE:], SMALLEST_SIGMA, out=columns[SIGMA_RANGE:])
    return Echoes(columns), int(len(good) - np.count_nonzero(good))


def table_of(detections: list[Detection]) -> Floats:
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
    """As the vehicle at its transmit time would have measured them."""
    usable: bool = True
    """False when the whole image shows nothing: then a missing echo says nothing."""
    looked: Sequence[tuple[float, float]] = ()
    """Ranges (from, to) that were processed, m; empty: all. Elsewhere a missing echo says nothing."""
    fan_turn: float = 0.0
    """By how much the fan turns to starboard while an echo comes from a metre farther, rad/m."""
