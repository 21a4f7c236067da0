"""What all observers filter alike: height and radius of objects, and the odds that they rest [SSIE eq. 2]."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices
from ods.compiled import native
from ods.tracker.observer.horizontal import HorizontalState

DISPROVED = -5.0
"""Log-odds at which the static hypothesis starts anew from where the moving one is now."""
PROVED = 8.0
"""Largest log-odds, so that an object that starts to move is believed in time."""
LEAST_VARIANCE = 1e-12


class CommonState(NamedTuple):
    """What all observers filter alike of n objects: (n,) each."""

    rest_height: Floats
    """Down, if the object does not move;"""
    rest_height_variance: Floats
    height: Floats
    """and if it moves,"""
    height_variance: Floats
    climb: Floats
    """with a velocity, and the other factors of the covariance (see `axis_kalman`):"""
    slope: Floats
    residual: Floats
    radius: Floats
    radius_variance: Floats
    odds: Floats
    """Log of P(static) / P(moving); infinite once settled."""
    pose_north: Floats
    """Variance of the vehicle's own position when the object was last seen, m^2: it is a bias, which echoes share."""
    pose_east: Floats
    rest_square: Floats
    """What is known of the square of the height, about its mean: mean and variance (`sensitivity.Heights`)."""
    rest_square_variance: Floats
    square: Floats
    """And if it moves."""
    square_variance: Floats


class NewCommon(NamedTuple):
    """Of k new objects."""

    height: Floats
    """(k,)."""
    variance: Floats
    """(k,) of the height."""
    radius: Floats
    """(k,)."""
    radius_variance: Floats
    """(k,)."""
    pose_variance: Floats
    """(2,), as in `PositionMeasurement`."""
    odds: float


def start(table: Floats, first: int, new: NewCommon, climb_variance: float) -> None:
    """Set objects from `first` on."""
    native.common_start(table, first, new, climb_variance)


def predict(table: Floats, dt: float, acceleration_noise: float, static_noise: float, radius_noise: float) -> None:
    """Carry all objects on over `dt` seconds; spectral densities of noise as in `MotionSettings`."""
    native.common_predict(table, dt, acceleration_noise, static_noise, radius_noise)


def all_static(odds: Floats) -> Floats:
    """Return (n,) the probabilities of log-odds."""
    static = np.empty(len(odds))
    native.all_static(odds, static)
    return static


def moments(table: Floats, horizontal: HorizontalState) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Return weight, position, variance, by_height and shared of `Belief`."""
    hypotheses, n = horizontal.covariance_ne.shape
    weight, by_height = np.empty((hypotheses, n)), np.empty((hypotheses, 2, n))
    position, variance, shared = (np.empty((hypotheses, 3, n)) for _ in range(3))
    native.hypotheses(table, horizontal, weight, position, variance, by_height, shared)
    return weight, position, variance, by_height, shared


class Velocities(NamedTuple):
    """Mean and variance, (2, n) north and east each, of n objects if they move."""

    mean: Floats
    variance: Floats
    steady_mean: Floats
    """Those of the first kind of motion, with which an object may creep."""
    steady_variance: Floats


def velocity(table: Floats, horizontal: HorizontalState, moving: Velocities, by_place: bool) -> Floats:
    """Return (2, 3, n) mean and variance of the mixture's velocities.

    The static hypothesis has velocity 0, but what echoes cannot tell from that yet is part of the variance. `by_place`:
    it creeps as likely as its place alone says (`creep.h`); else it is taken to.
    """
    moments = np.empty((2, 3, table.shape[1]))
    native.velocities(table, horizontal, moving, by_place, moments)
    return moments


def in_fan(table: Floats, rows: Indices, middle: Floats, half: Floats) -> Floats:
    """Return the fields of `Heights`: (5, 2, k)."""
    heights = np.empty((5, 2, len(rows)))
    native.in_fan(table, rows, middle, half, heights)
    return heights


def update(
    table: Floats,
    rows: Indices,
    seen: tuple[Floats, Floats, Floats],
    height_table: Floats,
    learned_table: Floats,
    since_s: Floats,
    change_rate: float,
) -> Indices:
    """Update height, radius and log-odds of `rows`; return those whose static hypothesis has to start anew.

    `seen`: radius, radius_variance and pose_variance of `PositionMeasurement`.
    """
    disproved = np.empty(len(rows), np.intp)
    limits = LEAST_VARIANCE, DISPROVED, PROVED
    count = native.common_update(
        table, rows, seen, height_table, learned_table, since_s, change_rate, limits, disproved
    )
    return disproved[:count]
