"""Input of the tracker from one ping: the vehicle's pose, the sonar's sector and the echoes, as plain arrays."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.base.frames.geometry import rotation_matrix
from ods.messages import Detection, Sector, UnseenPart, UnseenWhy
from ods.tracker.measurement.coverage.looked import ObservedRanges
from ods.tracker.named import Named

NO_NOISE = np.zeros(3)
NOT_SWEPT: UnseenWhy = "not swept"


class Vehicle(NamedTuple):
    """The sonar's head at the ping: what sees the echoes, wherever it sits on the vehicle."""

    position: Floats
    """(3,) NED, m."""
    rotation: Floats
    """(3, 3) body to global: R^-1 of eq. 1."""
    sigma_position: Floats
    """(3,) north, east, down, m."""
    sigma_attitude: Floats
    """(3,) roll, pitch, yaw, rad."""
    noise: Floats = NO_NOISE
    """(3,) standard deviations of north, east and tilt that count as new with every ping,"""
    bias: Floats = NO_NOISE
    """and (3,) of north, east and yaw that all pings share (`PoseNoise`)."""


def vehicle_at(position: Floats, attitude: Floats, sigma_position: Floats, sigma_attitude: Floats) -> Vehicle | None:
    """Return the vehicle of a pose (quaternion w, x, y, z, body to global); None when a number is not finite."""
    if not np.isfinite(np.concatenate([position, attitude, sigma_position, sigma_attitude])).all():
        return None
    numbers = position, rotation_matrix(attitude), sigma_position, sigma_attitude
    return Vehicle(*(np.ascontiguousarray(array, np.float64) for array in numbers))


class EchoRows(NamedTuple):
    """The m detections of one ping: (m,) each."""

    range_m: Floats
    bearing: Floats
    """rad, to starboard."""
    elevation: Floats
    """Of the plane the echo was seen in, up positive, rad."""
    radius: Floats
    """m."""
    sigma_range: Floats
    """m."""
    sigma_bearing: Floats
    """rad."""
    sigma_radius: Floats
    """m."""
    strength: Floats
    """Peak over the background, dB; 0: not reported."""
    cut: Floats
    """1: the fan's edge or its ranges cut it off; 0: they do not."""
    half_vertical: Floats
    """The body is within this of `elevation`, rad; 0: within half the fan's vertical opening."""
    onset: Floats
    """Rise of the leading edge, see `Detection.onset`; 0: not reported."""
    front: Floats
    """Probability of an object's leading edge, see `Detection.front`; 0: not reported."""


@dataclass(slots=True, eq=False)
class Echoes(Named[EchoRows]):
    """The detections of one ping: `table` is (12, m), its rows as in `EchoRows`."""

    record: Callable[..., EchoRows] = field(default=EchoRows, init=False)

    def __len__(self) -> int:
        return int(self.table.shape[1])

    def take(self, rows: Indices) -> "Echoes":
        """Return the echoes of an index array."""
        return Echoes(self.table.take(rows, axis=1))

    def joined(self, other: "Echoes") -> "Echoes":
        """Return the echoes of both."""
        if not len(other):
            return self
        return Echoes(np.concatenate([self.table, other.table], axis=1))


SMALLEST_SIGMA = 1e-4
"""Standard deviations below this (m, rad) are no claim a sonar can make; they are raised to it."""
LARGEST = 1e5
"""No range, radius or standard deviation of a sonar is larger."""


def echoes_of(table: Floats) -> tuple[Echoes, int]:
    """Return the echoes of a (m, 12) table with the columns of `EchoRows`, and how many rows were dropped as useless.

    The last columns may be missing, (m, 7) to (m, 11): unknown, and not cut. Dropped: numbers that are not finite or
    absurdly large, ranges not above 0, negative radii or standard deviations.
    """
    missing = len(EchoRows._fields) - table.shape[1]
    table = np.column_stack([table, np.zeros((len(table), missing))]) if missing else table
    rows = EchoRows(*table.T)
    claims = np.array([rows.radius, rows.sigma_range, rows.sigma_bearing, rows.sigma_radius])
    good = (np.abs(table) <= LARGEST).all(axis=1) & (rows.range_m > 0.0) & (claims >= 0.0).all(axis=0)
    echoes = Echoes(np.ascontiguousarray(table[good].T))
    for sigma in (echoes.rows.sigma_range, echoes.rows.sigma_bearing, echoes.rows.sigma_radius):
        np.maximum(sigma, SMALLEST_SIGMA, out=sigma)
    return echoes, int(len(good) - np.count_nonzero(good))


def echo_table_of(detections: list[Detection]) -> Floats:
    """Return the (m, 12) table of `echoes_of` for a message's detections."""
    half = math.sqrt(3.0)  # of an interval in which all places are alike, in its standard deviations
    rows = [
        (
            *(d.range_m, d.bearing_rad, d.elevation_rad, d.radius_m),
            *(d.sigma_range_m, d.sigma_bearing_rad, d.sigma_radius_m, d.snr_db, d.cut),
            *(half * d.sigma_elevation_rad, d.onset, d.front),
        )
        for d in detections
    ]
    return np.array(rows, np.float64).reshape(-1, len(EchoRows._fields))


def nothing_unseen() -> Floats:
    """Return no parts."""
    return np.empty((0, 4))


def unseen_of(parts: Sequence[UnseenPart]) -> Floats:
    """Return the (k, 4) `unseen` of `Scan`; what is no part of a sector is left out."""
    rows = [(p.bearing_min_rad, p.bearing_max_rad, p.range_min_m, p.range_max_m) for p in parts if p.why != NOT_SWEPT]
    table = np.array(rows, np.float64).reshape(-1, 4)
    return np.ascontiguousarray(table[(np.abs(table) <= LARGEST).all(axis=1)])


def not_swept_of(parts: Sequence[UnseenPart]) -> Floats:
    """Return the (k, 2) `not_swept` of `Scan`."""
    rows = [(p.bearing_min_rad, p.bearing_max_rad) for p in parts if p.why == NOT_SWEPT]
    return np.array(rows, np.float64).reshape(-1, 2)


@dataclass(frozen=True, slots=True)
class Scan:
    """One ping."""

    t_ns: int
    """Transmit time, CLOCK_MONOTONIC or any other clock that never goes back."""
    utc_ns: int
    vehicle: Vehicle | None
    """None when no pose is known for this time: then objects are only predicted."""
    sector: Sector
    echoes: Echoes
    """As the vehicle at its transmit time would have measured them."""
    usable: bool = True
    """False when the whole image shows nothing: then a missing echo says nothing."""
    processed_ranges_m: Sequence[tuple[float, float]] = ()
    """Ranges (from, to) that were processed; empty: all. Elsewhere a missing echo says nothing."""
    fan_turn: float = 0.0
    """By how much the fan turns to starboard while an echo comes from a metre farther, rad/m."""
    unseen: Floats = field(default_factory=nothing_unseen)
    """(k, 4) parts of the sector that the ping could not show: least and largest bearing, rad, and range, m."""
    looked: ObservedRanges | None = None
    """How far the ping saw in each direction; None: it has no range image."""
    skipped_pings: int = 0
    """Pings since the scan before whose images were not looked at: they missed nothing."""
    not_swept: Floats = field(default_factory=lambda: np.empty((0, 2)))
    """(k, 2) least and largest bearings, rad, of what a mechanically scanned head did not come by: objects whose middle
    is there are determined by other pings."""
